//! The nodes of a BVH one by one, as a tree to explore: boxes, areas, what lies below, and how well children share the
//! space of their parent.

use std::ops::Range;

use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::constants::NO_NODE;
use raystep_kernels::structures::bvh::WideContent;

/// A node: of the binary BVH under its own index; of the wide one an inner node, or a leaf in one of its slots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Lower corner of its box, traced units.
    pub min: [f32; 3],
    /// Upper corner.
    pub max: [f32; 3],
    /// Its parent; `None` for the root.
    pub parent: Option<u32>,
    /// Levels below the root.
    pub level: u32,
    /// Triangles that it lists, if it is a leaf.
    pub listed: u32,
    /// Triangles listed in all leaves below, its own included.
    pub below: u32,
    /// Leaves below, itself included.
    pub leaves: u32,
    /// Expected cost of its subtree for a ray that hits the root's box, in triangle tests.
    pub cost: f32,
    first: u32,
    children: u32,
}

impl Node {
    /// Whether it has no children.
    #[must_use]
    pub fn is_leaf(&self) -> bool {
        self.children == 0
    }

    /// Its children, by index.
    #[must_use]
    pub fn children(&self) -> Range<u32> {
        self.first..self.first.saturating_add(self.children)
    }

    /// Half of its surface, traced units squared.
    #[must_use]
    pub fn half_area(&self) -> f64 {
        half_area(self.min, self.max)
    }
}

fn half_area(min: [f32; 3], max: [f32; 3]) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|i| (f64::from(max[i]) - f64::from(min[i])).max(0.0));
    x * y + y * z + z * x
}

/// How the children of a node fill it: shares of its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filling {
    /// In none of them.
    pub empty: f64,
    /// In two or more of them.
    pub overlapping: f64,
}

/// What to rank nodes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RankBy {
    /// The area in which children overlap: rays that enter it visit both.
    Overlap,
    /// The empty part, weighted by the probability of a visit: rays that pass through it visit the node in vain.
    Empty,
    /// Triangles listed.
    Listed,
    /// Level.
    Level,
}

/// The nodes of a BVH; children lie side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    nodes: Vec<Node>,
    is_wide: bool,
}

impl Nodes {
    /// The nodes of a scene's BVH; `None` without one. Takes 60 bytes of memory per node.
    #[must_use]
    pub fn of(data: &SceneData) -> Option<Self> {
        let (mut nodes, is_wide) = match (data.wide_nodes.is_empty(), data.bvh_nodes.is_empty()) {
            (false, _) => (wide(data), true),
            (true, false) => (binary(data), false),
            (true, true) => return None,
        };
        sum_up(&mut nodes, is_wide);
        Some(Self { nodes, is_wide })
    }

    /// Whether it is the compressed eight-wide BVH, else the binary one.
    #[must_use]
    pub fn is_wide(&self) -> bool {
        self.is_wide
    }

    /// A node; the root is node 0.
    #[must_use]
    pub fn get(&self, node: u32) -> Option<&Node> {
        self.nodes.get(node as usize)
    }

    /// The number of nodes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there are none; never so.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The probability that a ray which hits the root's box hits this one, if both are convex and the ray random: the
    /// ratio of their areas (Goldsmith and Salmon, 1987; MacDonald and Booth, 1990). `None` if the root has no area.
    #[must_use]
    pub fn probability(&self, node: u32) -> Option<f64> {
        let (area, whole) = (self.get(node)?.half_area(), self.get(0)?.half_area());
        (whole > 0.0 && whole.is_finite()).then(|| area / whole)
    }

    /// The cost of this node alone in the surface area heuristic: a visit, and its tests, times its probability.
    #[must_use]
    pub fn own_cost(&self, node: u32) -> Option<f64> {
        Some(self.probability(node)? * visits_and_tests(self.get(node)?, self.is_wide))
    }

    /// How the children of a node fill it. `None` for a leaf, and for a box without volume.
    #[must_use]
    pub fn filling(&self, node: u32) -> Option<Filling> {
        let node = self.get(node).filter(|node| !node.is_leaf())?;
        let boxes: Vec<[[f32; 3]; 2]> =
            node.children().filter_map(|child| self.get(child)).map(|c| [c.min, c.max]).collect();
        filling([node.min, node.max], &boxes)
    }

    /// The half area of what two children have in common, summed over all pairs, relative to that of the root.
    #[must_use]
    pub fn overlap(&self, node: u32) -> Option<f64> {
        let (node, whole) = (self.get(node)?, self.get(0)?.half_area());
        let children: Vec<&Node> = node.children().filter_map(|child| self.get(child)).collect();
        let mut sum = 0.0;
        for (i, a) in children.iter().enumerate() {
            for b in &children[i + 1..] {
                let (min, max) = ([0, 1, 2].map(|k| a.min[k].max(b.min[k])), [0, 1, 2].map(|k| a.max[k].min(b.max[k])));
                if (0..3).all(|k| min[k] <= max[k]) {
                    sum += half_area(min, max);
                }
            }
        }
        (whole > 0.0 && whole.is_finite()).then(|| sum / whole)
    }

    /// The nodes with the largest values, largest first, at most `most`; those without a value are left out.
    #[must_use]
    pub fn ranked(&self, by: RankBy, most: usize) -> Vec<u32> {
        let value = |i: u32| match by {
            RankBy::Overlap => self.overlap(i),
            RankBy::Empty => self.filling(i).and_then(|f| Some(f.empty * self.probability(i)?)),
            RankBy::Listed => self.get(i).map(|node| f64::from(node.listed)),
            RankBy::Level => self.get(i).filter(|node| node.is_leaf()).map(|node| f64::from(node.level)),
        };
        let count = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        let mut all: Vec<(u32, f64)> =
            (0..count).filter_map(|i| Some((i, value(i)?))).filter(|(_, v)| *v > 0.0).collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all.into_iter().take(most).map(|(i, _)| i).collect()
    }

    /// The nodes from the root down to this one.
    #[must_use]
    pub fn path(&self, node: u32) -> Vec<u32> {
        let above = std::iter::successors(Some(node), |&at| self.get(at)?.parent);
        let mut path: Vec<u32> = above.take(self.nodes.len()).collect();
        path.reverse();
        path
    }
}

/// A visit and its tests; a leaf of a wide node is visited together with the node.
fn visits_and_tests(node: &Node, is_wide: bool) -> f64 {
    let visit = if is_wide && node.is_leaf() { 0.0 } else { 1.0 };
    visit + f64::from(node.listed)
}

fn node(min: [f32; 3], max: [f32; 3], parent: Option<(u32, u32)>) -> Node {
    let (parent, level) = parent.map_or((None, 0), |(parent, level)| (Some(parent), level + 1));
    Node { min, max, parent, level, listed: 0, below: 0, leaves: 0, cost: 0.0, first: 0, children: 0 }
}

fn binary(data: &SceneData) -> Vec<Node> {
    let count = u32::try_from(data.bvh_nodes.len()).unwrap_or(u32::MAX);
    let mut nodes: Vec<Node> = data.bvh_nodes.iter().map(|n| node(n.min, n.max, None)).collect();
    for (i, from) in (0..count).zip(&data.bvh_nodes) {
        let level = nodes[i as usize].level;
        if !from.is_inner() {
            nodes[i as usize].listed = from.count();
            continue;
        }
        // Children come after their parents.
        if from.first <= i || from.first.checked_add(1).is_none_or(|last| last >= count) {
            continue;
        }
        (nodes[i as usize].first, nodes[i as usize].children) = (from.first, 2);
        for child in [from.first, from.first + 1] {
            (nodes[child as usize].parent, nodes[child as usize].level) = (Some(i), level + 1);
        }
    }
    nodes
}

fn wide(data: &SceneData) -> Vec<Node> {
    let boxes = |index: u32| data.wide_nodes.get(index as usize).into_iter().flat_map(|n| n.children());
    let f32s = |v: [f64; 3]| v.map(|v| v as f32);
    let (min, max) = boxes(0).fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(min, max), child| {
        let (lo, hi) = (f32s(child.min), f32s(child.max));
        ([0, 1, 2].map(|i| min[i].min(lo[i])), [0, 1, 2].map(|i| max[i].max(hi[i])))
    });
    let [min, max] = if min[0] <= max[0] { [min, max] } else { [[0.0; 3]; 2] };
    let mut nodes = vec![node(min, max, None)];
    // The inner nodes that wait, with their indices in the buffer and here; each is reached once.
    let mut waiting = std::collections::VecDeque::from([(0u32, 0u32)]);
    while let Some((from, to)) = waiting.pop_front() {
        let level = nodes[to as usize].level;
        let first = nodes.len() as u32;
        for child in boxes(from) {
            let at = nodes.len() as u32;
            let mut made = node(f32s(child.min), f32s(child.max), Some((to, level)));
            match child.content {
                WideContent::Inner(next) if nodes.len() <= data.wide_nodes.len().saturating_mul(9) => {
                    waiting.push_back((next, at));
                }
                WideContent::Inner(_) => {}
                WideContent::Leaf { count, .. } => made.listed = count,
            }
            nodes.push(made);
        }
        (nodes[to as usize].first, nodes[to as usize].children) = (first, nodes.len() as u32 - first);
    }
    nodes
}

/// What lies below each node, from the leaves up: parents come before their children.
fn sum_up(nodes: &mut [Node], is_wide: bool) {
    let whole = nodes.first().map_or(0.0, Node::half_area);
    for i in (0..nodes.len()).rev() {
        let mut this = nodes[i];
        let share = if whole > 0.0 && whole.is_finite() { this.half_area() / whole } else { 0.0 };
        this.below += this.listed;
        this.leaves += u32::from(this.is_leaf());
        this.cost += (share * visits_and_tests(&this, is_wide)) as f32;
        nodes[i] = this;
        if let Some(parent) = this.parent.filter(|&parent| parent != NO_NODE) {
            let parent = &mut nodes[parent as usize];
            (parent.below, parent.leaves) = (parent.below + this.below, parent.leaves + this.leaves);
            parent.cost += this.cost;
        }
    }
}

/// Shares of a box in none and in several of some boxes: all planes cut it into smaller boxes, each of which is in a box
/// as a whole or not at all.
fn filling([min, max]: [[f32; 3]; 2], boxes: &[[[f32; 3]; 2]]) -> Option<Filling> {
    let planes = [0, 1, 2].map(|axis| {
        let inside = |v: f32| v.clamp(min[axis], max[axis].max(min[axis]));
        let mut planes: Vec<f32> = boxes.iter().flatten().map(|corner| inside(corner[axis])).collect();
        planes.extend([min[axis], max[axis]]);
        planes.sort_by(f32::total_cmp);
        planes.dedup();
        planes
    });
    let (mut whole, mut empty, mut overlapping) = (0.0, 0.0, 0.0);
    for x in planes[0].windows(2) {
        for y in planes[1].windows(2) {
            for z in planes[2].windows(2) {
                let piece = [x, y, z];
                let side = |axis: usize| f64::from(piece[axis][1]) - f64::from(piece[axis][0]);
                let volume = side(0) * side(1) * side(2);
                let contains = |b: &&[[f32; 3]; 2]| (0..3).all(|i| b[0][i] <= piece[i][0] && piece[i][1] <= b[1][i]);
                whole += volume;
                match boxes.iter().filter(contains).count() {
                    0 => empty += volume,
                    1 => {}
                    _ => overlapping += volume,
                }
            }
        }
    }
    (whole > 0.0 && whole.is_finite()).then(|| Filling { empty: empty / whole, overlapping: overlapping / whole })
}

#[cfg(test)]
mod tests;
