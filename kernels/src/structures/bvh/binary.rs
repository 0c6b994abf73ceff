//! The binary BVH in the kernels' format.

use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

use super::references::{Bounds, References};
use super::tree::{self, TreeShape};
use super::{BvhError, BvhOptions, Padding, down, fits, up};
use crate::shared::bvh_walk::{BvhNode, EMPTY};
use crate::shared::constants::NO_NODE;

/// Most triangles per leaf.
pub const MAX_LEAF: u32 = 4;

/// Cost of visiting an inner node, in units of a triangle test: each is one step of the walk.
const NODE_COST: f64 = 1.0;

/// A binary BVH.
#[derive(Clone, Debug, PartialEq)]
pub struct BvhData {
    /// The root first, siblings adjacent; at least one node.
    pub nodes: Vec<BvhNode>,
    /// The parent of each node; [`NO_NODE`] for the root.
    pub parents: Vec<u32>,
    /// Triangle ids in the order of the leaves; at least one entry, which an empty BVH does not use.
    pub items: Vec<u32>,
    /// Nodes on the longest path from the root to a leaf, both included.
    pub depth: u32,
    /// How the boxes are grown.
    pub padding: Padding,
    /// Triangles and pieces of triangles; a leaf lists a triangle once, however many of its pieces it holds.
    pub references: u32,
    /// Expected number of steps of a ray that passes through the scene without a hit, by the surface area heuristic on
    /// boxes that are not grown: one per inner node, one per triangle.
    pub cost: f64,
    /// How the tree was built.
    pub shape: TreeShape,
}

pub(super) fn build(
    vertices: &[f32],
    padding: Padding,
    references: &References,
    options: &BvhOptions,
) -> Result<BvhData, BvhError> {
    let data = if references.boxes.is_empty() {
        empty(padding)
    } else {
        let (tree, shape) = tree::build(&references.boxes, options.quality.effort());
        let (leaves, cost) = collapse(&tree);
        layout(&tree, &leaves, references, padding, cost, shape)
    };
    fits("bvh_nodes", 8 * data.nodes.len() as u64, options)?;
    fits("bvh_items", data.items.len() as u64, options)?;
    debug_assert_eq!(data.check(vertices), Ok(()));
    Ok(data)
}

fn empty(padding: Padding) -> BvhData {
    BvhData {
        nodes: vec![BvhNode { min: [f32::MAX; 3], first: 0, max: [f32::MAX; 3], link: EMPTY }],
        parents: vec![NO_NODE],
        items: vec![0],
        depth: 1,
        padding,
        references: 0,
        cost: 0.0,
        shape: TreeShape::Optimised,
    }
}

/// Decides which nodes become leaves; also returns the resulting cost of the tree.
fn collapse(tree: &Bvh2) -> (Vec<bool>, f64) {
    let mut order = Vec::with_capacity(tree.nodes.len());
    tree::walk(&tree.nodes, |node, _| order.push(node));
    let mut leaves = vec![false; tree.nodes.len()];
    let mut below = vec![(0.0f64, 0u32); tree.nodes.len()];
    for &i in order.iter().rev() {
        let node = &tree.nodes[i as usize];
        let area = f64::from(node.aabb().half_area());
        let (inner, count) = if node.is_leaf() {
            (f64::INFINITY, 1)
        } else {
            let [a, b] = [0, 1].map(|child| below[node.first_index as usize + child]);
            (area * NODE_COST + a.0 + b.0, a.1 + b.1)
        };
        let leaf = area * f64::from(count);
        leaves[i as usize] = count <= MAX_LEAF && leaf <= inner;
        below[i as usize] = (if leaves[i as usize] { leaf } else { inner }, count);
    }
    let root = f64::from(tree.nodes[0].aabb().half_area());
    (leaves, if root > 0.0 { below[0].0 / root } else { 0.0 })
}

/// Lays out the nodes in the order in which a walk that enters every node meets them.
fn layout(
    tree: &Bvh2,
    leaves: &[bool],
    references: &References,
    padding: Padding,
    cost: f64,
    shape: TreeShape,
) -> BvhData {
    let growth = padding.growth();
    let mut data = BvhData {
        nodes: vec![boxed(&tree.nodes[0], growth)],
        parents: vec![NO_NODE],
        items: Vec::with_capacity(references.boxes.len()),
        depth: 0,
        padding,
        references: references.boxes.len() as u32,
        cost,
        shape,
    };
    let mut waiting = vec![(0u32, 0usize, 1u32)];
    while let Some((from, to, level)) = waiting.pop() {
        data.depth = data.depth.max(level);
        if leaves[from as usize] {
            let start = data.items.len();
            list(tree, from, references, &mut data.items);
            data.nodes[to].first = start as u32;
            data.nodes[to].link = (data.items.len() - start) as u32;
            continue;
        }
        let first = tree.nodes[from as usize].first_index;
        let mut children = [first, first + 1].map(|i| (i, boxed(&tree.nodes[i as usize], growth)));
        let (axis, swap) = order(&children[0].1, &children[1].1);
        if swap {
            children.swap(0, 1);
        }
        let place = data.nodes.len();
        data.nodes[to].first = place as u32;
        data.nodes[to].link = (axis as u32) << 30;
        data.nodes.extend(children.map(|(_, node)| node));
        data.parents.extend([to as u32; 2]);
        waiting.push((children[1].0, place + 1, level + 1));
        waiting.push((children[0].0, place, level + 1));
    }
    data
}

fn boxed(node: &Bvh2Node, growth: f32) -> BvhNode {
    let [min, max] = Bounds::of(node.aabb()).grown(f64::from(growth));
    BvhNode { min: min.map(down), max: max.map(up), ..BvhNode::default() }
}

/// The axis along which the centres of two boxes differ most, and whether the second box is the lower one.
pub(super) fn order(a: &BvhNode, b: &BvhNode) -> (usize, bool) {
    let twice = |n: &BvhNode, axis: usize| f64::from(n.min[axis]) + f64::from(n.max[axis]);
    let apart = [0, 1, 2].map(|axis| twice(b, axis) - twice(a, axis));
    let axis = (1..3).fold(0, |best: usize, axis| if apart[axis].abs() > apart[best].abs() { axis } else { best });
    (axis, apart[axis] < 0.0)
}

/// Appends the triangles below a node, each once.
fn list(tree: &Bvh2, from: u32, references: &References, items: &mut Vec<u32>) {
    let start = items.len();
    let mut waiting = vec![from];
    while let Some(i) = waiting.pop() {
        let node = &tree.nodes[i as usize];
        if node.is_leaf() {
            let triangle = references.triangles[node.first_index as usize];
            if !items[start..].contains(&triangle) {
                items.push(triangle);
            }
        } else {
            waiting.extend([node.first_index + 1, node.first_index]);
        }
    }
}
