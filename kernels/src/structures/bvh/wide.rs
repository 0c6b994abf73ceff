//! The wide BVH: obvhs decides which nodes of the binary tree become children of which wide node; the boxes are
//! quantised here.

use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;

use super::references::{Bounds, References};
use super::tree::{self, TreeShape};
use super::{BvhError, BvhOptions, Padding, down, fits};
use crate::numbers::units::floor_log2;
use crate::shared::constants::WIDE_MAX_DEPTH;
use crate::shared::packed_triangles::{PackedTriangle, pack};
use crate::shared::wide_node::{WideContent, WideNode, spacing};

/// Most triangles per leaf.
pub const MAX_WIDE_LEAF: u32 = 3;

/// Cost of a triangle test, in units of a node visit: the value obvhs uses to choose the children.
const TRIANGLE_COST: f64 = 0.3;

/// A wide BVH.
#[derive(Clone, Debug, PartialEq)]
pub struct WideBvhData {
    /// The root first, children after their parents. Without triangles, the root has only empty slots.
    pub nodes: Vec<WideNode>,
    /// In the order of the leaves. At least one entry, which an empty BVH does not use.
    pub triangles: Vec<PackedTriangle>,
    /// Nodes on the longest path from the root, both ends included; at most [`WIDE_MAX_DEPTH`].
    pub depth: u32,
    /// How the boxes are grown.
    pub padding: Padding,
    /// Triangles and pieces of triangles: the number of entries of `triangles` in use.
    pub references: u32,
    /// Expected cost of a ray that passes through the scene without a hit, by the surface area heuristic on boxes that
    /// are not grown: 1 per node, 0.3 per triangle.
    pub cost: f64,
    /// How the tree was built.
    pub shape: TreeShape,
    /// Number of planes, as computed by obvhs, that would have cut off part of a box that is not grown.
    pub repaired: u64,
}

pub(super) fn build(
    vertices: &[f32],
    padding: Padding,
    references: &References,
    options: &BvhOptions,
) -> Result<WideBvhData, BvhError> {
    let count = references.boxes.len();
    fits("packed_triangles", 12 * count as u64, options)?;
    if count == 0 {
        return Ok(empty(padding));
    }
    let (tree, mut shape) = tree::build(&references.boxes, options.quality.effort());
    let (mut wide, mut depth) = widen(tree);
    if depth > WIDE_MAX_DEPTH {
        let tree;
        (tree, shape) = tree::halved(&references.boxes);
        (wide, depth) = widen(tree);
    }
    fits("wide_nodes", 20 * wide.nodes.len() as u64, options)?;
    let quantised = quantise(&wide, references, padding.growth());
    let data = WideBvhData {
        nodes: quantised.nodes,
        triangles: wide
            .primitive_indices
            .iter()
            .map(|&reference| pack(vertices, references.triangles[reference as usize]))
            .collect(),
        depth,
        padding,
        references: count as u32,
        cost: quantised.cost,
        shape,
        repaired: quantised.repaired,
    };
    debug_assert_eq!(data.check(vertices), Ok(()));
    Ok(data)
}

fn empty(padding: Padding) -> WideBvhData {
    WideBvhData {
        nodes: vec![WideNode { exponents: [1; 3], planes: [[[255; 8], [0; 8]]; 3], ..WideNode::default() }],
        triangles: vec![[0; 12]],
        depth: 1,
        padding,
        references: 0,
        cost: 0.0,
        shape: TreeShape::Optimised,
        repaired: 0,
    }
}

/// The wide tree with obvhs' boxes, and its depth. The recursion is as deep as the binary tree.
fn widen(tree: Bvh2) -> (CwBvh, u32) {
    let wide = bvh2_to_cwbvh(&tree, MAX_WIDE_LEAF, true, false);
    let mut levels = vec![1u32; wide.nodes.len()];
    // Children come after their parents.
    for (i, node) in wide.nodes.iter().enumerate() {
        for child in 0..node.imask.count_ones() {
            levels[(node.child_base_idx + child) as usize] = levels[i] + 1;
        }
    }
    let depth = levels.into_iter().max().unwrap_or(1);
    (wide, depth)
}

struct Quantised {
    nodes: Vec<WideNode>,
    cost: f64,
    repaired: u64,
}

/// Nodes with planes that contain the exact boxes, grown. Children first, since a node's box is the union of theirs.
fn quantise(wide: &CwBvh, references: &References, growth: f32) -> Quantised {
    let mut nodes = vec![WideNode::default(); wide.nodes.len()];
    let mut boxes = vec![Bounds::EMPTY; wide.nodes.len()];
    let (mut area, mut repaired) = (0.0, 0);
    for i in (0..nodes.len()).rev() {
        let theirs = &wide.nodes[i];
        let mut node = WideNode {
            child_base: theirs.child_base_idx,
            triangle_base: theirs.primitive_base_idx,
            contents: contents(theirs),
            ..WideNode::default()
        };
        let mut children = [Bounds::EMPTY; 8];
        for (slot, bounds) in children.iter_mut().enumerate() {
            match node.content(slot) {
                Some(WideContent::Inner(child)) => *bounds = boxes[child as usize],
                Some(WideContent::Leaf { first, count }) => {
                    for at in first..first + count {
                        bounds.join(&references.bounds(wide.primitive_indices[at as usize]));
                    }
                    area += bounds.half_area() * f64::from(count) * TRIANGLE_COST;
                }
                None => continue,
            }
            boxes[i].join(bounds);
        }
        area += boxes[i].half_area();
        repaired += cut_off(theirs, &node, &children);
        place(&mut node, &boxes[i], &children, f64::from(growth));
        nodes[i] = node;
    }
    let root = boxes.first().map_or(0.0, Bounds::half_area);
    Quantised { nodes, cost: if root > 0.0 { area / root } else { 0.0 }, repaired }
}

/// The content of the slots. obvhs numbers the entries of a node's leaves by ascending slots, as we do.
fn contents(theirs: &CwBvhNode) -> u32 {
    let leaves = (0..8).filter(|slot| theirs.imask >> slot & 1 == 0);
    let entries = leaves.map(|slot| u32::from(theirs.child_meta[slot] >> 5) << (3 * slot));
    u32::from(theirs.imask) << 24 | entries.sum::<u32>()
}

/// Sets origin, exponents and planes.
fn place(node: &mut WideNode, bounds: &Bounds, children: &[Bounds; 8], growth: f64) {
    let [min, max] = bounds.grown(growth);
    for axis in 0..3 {
        let origin = down(min[axis]);
        node.origin[axis] = origin;
        let origin = f64::from(origin);
        // No larger than necessary: 255 spacings are less than 2^8.
        let guess = floor_log2((max[axis] - origin).max(f64::MIN_POSITIVE)) - 8 + 127;
        let mut exponent = guess.clamp(1, 254) as u8;
        while exponent < 254 && !reaches(origin, 255.0 * spacing(exponent), max[axis]) {
            exponent += 1;
        }
        node.exponents[axis] = exponent;
        let spacing = spacing(exponent);
        for (slot, child) in children.iter().enumerate() {
            let is_empty = node.content(slot).is_none();
            let planes = &mut node.planes[axis];
            if is_empty {
                (planes[0][slot], planes[1][slot]) = (255, 0);
                continue;
            }
            let [low, high] = child.grown(growth).map(|corner| corner[axis]);
            // Rounded in f64, then corrected until the inequality holds exactly.
            let mut q = ((low - origin) / spacing).floor().clamp(0.0, 255.0);
            while q > 0.0 && !below(origin, q * spacing, low) {
                q -= 1.0;
            }
            planes[0][slot] = q as u8;
            let mut q = ((high - origin) / spacing).ceil().clamp(0.0, 255.0);
            while q < 255.0 && !reaches(origin, q * spacing, high) {
                q += 1.0;
            }
            planes[1][slot] = q as u8;
        }
    }
}

/// `value - from` and its rounding error: the two add up to the exact difference.
fn difference(value: f64, from: f64) -> (f64, f64) {
    let rounded = value - from;
    let back = value - rounded;
    (rounded, (value - (rounded + back)) + (back - from))
}

/// Whether `origin + offset >= value`, exactly.
pub(super) fn reaches(origin: f64, offset: f64, value: f64) -> bool {
    let (rounded, rest) = difference(value, origin);
    offset > rounded || offset == rounded && rest <= 0.0
}

/// Whether `origin + offset <= value`, exactly.
pub(super) fn below(origin: f64, offset: f64, value: f64) -> bool {
    reaches(-origin, -offset, -value)
}

/// How many of obvhs' planes are inside the exact boxes.
fn cut_off(theirs: &CwBvhNode, node: &WideNode, children: &[Bounds; 8]) -> u64 {
    let mins = [theirs.child_min_x, theirs.child_min_y, theirs.child_min_z];
    let maxs = [theirs.child_max_x, theirs.child_max_y, theirs.child_max_z];
    let mut planes = 0;
    for axis in 0..3 {
        let (origin, spacing) = (f64::from(theirs.p[axis]), spacing(theirs.e[axis]));
        for (slot, child) in children.iter().enumerate().filter(|(slot, _)| node.content(*slot).is_some()) {
            let (low, high) = (f64::from(child.min[axis]), f64::from(child.max[axis]));
            planes += u64::from(!below(origin, f64::from(mins[axis][slot]) * spacing, low));
            planes += u64::from(!reaches(origin, f64::from(maxs[axis][slot]) * spacing, high));
        }
    }
    planes
}
