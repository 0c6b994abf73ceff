//! The tree from which both forms are made: one reference per leaf, exact boxes.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;

use super::{Effort, cluster, median};

/// Most levels of the tree that is collapsed; `obvhs` recurses over them.
pub const MAX_DEPTH: u32 = 64;

/// How a tree was built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeShape {
    /// Clustered, and improved if the quality asks for it.
    Optimised,
    /// Only clustered: the improved tree would have been too deep.
    Clustered,
    /// Halved at medians: the clustered tree would have been too deep.
    Halved,
}

/// Sum of the optimiser's 16 rounds, in units of the first: 1 + 1/3 + 1/5 + … + 1/31.
const ROUNDS: f64 = 2.38;

/// Builds a tree over `boxes`, at least one.
pub(super) fn build(boxes: &[Aabb], effort: Effort) -> (Bvh2, TreeShape) {
    let clustered = cluster::cluster(boxes, effort.search);
    if depth(&clustered) > MAX_DEPTH {
        return halved(boxes);
    }
    let ratio = bounded_ratio(&clustered, effort);
    let mut tree = wrap(clustered);
    if ratio <= 0.0 {
        return (tree, TreeShape::Optimised);
    }
    ReinsertionOptimizer::default().run(&mut tree, ratio, None);
    if depth(&tree.nodes) > MAX_DEPTH {
        return (wrap(cluster::cluster(boxes, effort.search)), TreeShape::Clustered);
    }
    (tree, TreeShape::Optimised)
}

/// The fallback tree.
pub(super) fn halved(boxes: &[Aabb]) -> (Bvh2, TreeShape) {
    (wrap(median::halve(boxes)), TreeShape::Halved)
}

fn wrap(nodes: Vec<Bvh2Node>) -> Bvh2 {
    let references = nodes.len().div_ceil(2) as u32;
    Bvh2 { nodes, primitive_indices: (0..references).collect(), max_depth: MAX_DEPTH as usize, ..Bvh2::default() }
}

/// The share of nodes to reinsert in the first round. A node's search visits all boxes that contain it, and on average
/// their number is at most the sum of all areas divided by the root's.
fn bounded_ratio(nodes: &[Bvh2Node], effort: Effort) -> f32 {
    let area = |node: &Bvh2Node| f64::from(node.aabb().half_area());
    let root = nodes.first().map_or(0.0, area);
    let overlap = nodes.iter().filter(|n| !n.is_leaf()).map(area).sum::<f64>() / root.max(f64::MIN_POSITIVE);
    effort.reinsertion.min((effort.budget / (ROUNDS * overlap.max(1.0))) as f32)
}

/// Calls `f` with every node, before its children, and the node's level; the root's is 1.
pub(super) fn walk(nodes: &[Bvh2Node], mut f: impl FnMut(u32, u32)) {
    let mut waiting = vec![(0, 1)];
    while let Some((node, level)) = waiting.pop() {
        f(node, level);
        let Some(inner) = nodes.get(node as usize).filter(|n| !n.is_leaf()) else { continue };
        waiting.push((inner.first_index + 1, level + 1));
        waiting.push((inner.first_index, level + 1));
    }
}

pub(super) fn depth(nodes: &[Bvh2Node]) -> u32 {
    let mut depth = 0;
    walk(nodes, |_, level| depth = depth.max(level));
    depth
}

#[cfg(test)]
mod tests {
    use super::super::BvhQuality;
    use super::*;
    use glam::Vec3A;

    /// Every search would visit all of 10,000 identical boxes, but only few of those that lie apart.
    #[test]
    fn fewer_nodes_are_moved_where_all_boxes_overlap() {
        let effort = BvhQuality::High.effort();
        let ratio = |step: f32| {
            let boxes: Vec<Aabb> = (0..10_000u16)
                .map(|i| Vec3A::splat(f32::from(i) * step))
                .map(|low| Aabb::new(low, low + Vec3A::ONE))
                .collect();
            bounded_ratio(&cluster::cluster(&boxes, effort.search), effort)
        };
        assert_eq!(ratio(2.0), effort.reinsertion);
        assert!(ratio(0.0) < 0.05, "{}", ratio(0.0));
    }
}
