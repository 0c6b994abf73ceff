//! The nodes of a walk through the BVH.

use raystep_kernels::export::trace::{RayState, TraceRow};
use raystep_kernels::program::Path;
use raystep_kernels::programs::closest_hit::states;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::bvh_walk::parent_of;
use raystep_kernels::shared::constants::NO_NODE;
use raystep_kernels::structures::bvh::BvhNode;

use super::{Aabb, WalkGeometry, path_of};

/// A node whose box was tested. Returning upwards through a node does not count as a visit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeVisit {
    /// The row that tested it.
    pub row: usize,
    /// The node.
    pub node: u32,
    /// The parent; `None` for the root.
    pub parent: Option<u32>,
    /// Its box.
    pub bounds: Aabb,
    /// Levels below the root.
    pub depth: u32,
    /// Whether the ray meets the box before its nearest hit so far, as decided by the device.
    pub is_met: bool,
    /// Whether it is a leaf.
    pub is_leaf: bool,
    /// Triangles that a leaf lists.
    pub listed: u32,
    /// The t interval, from 0, in which the ray is in the box, regardless of hits; computed in f64.
    pub inside: Option<[f64; 2]>,
}

impl WalkGeometry {
    /// Processes a row that may test a node's box.
    pub(super) fn move_to_node(&mut self, data: &SceneData, i: usize, row: &TraceRow, before: Option<&RayState>) {
        let after = &row.after;
        self.current_node = after.is_walking.then_some(after.cell_index);
        let current = self.current_node.and_then(|node| data.bvh_nodes.get(node as usize));
        self.current_box = current.map(|node| Aabb::of_f32(node.min, node.max));
        let Some(before) = before.filter(|_| path_of(row) == Path::NextNode) else { return };
        let index = before.cell_index;
        let Some(node) = data.bvh_nodes.get(index as usize) else { return };
        let parent = parent(data, index);
        // Returning from a child, or from the leaf itself: its box is not tested again.
        if before.previous != Some(parent.unwrap_or(NO_NODE)) {
            return;
        }
        let is_leaf = node.count() != 0;
        let went_down = after.previous == Some(index)
            && (after.cell_index == node.first || Some(after.cell_index) == node.first.checked_add(1))
            && after.is_walking;
        let in_leaf = matches!(states::of_any_ray(after.tag), states::ISECT_HIT | states::ISECT_NO_HIT);
        let bounds = Aabb::of_f32(node.min, node.max);
        self.nodes.push(NodeVisit {
            row: i,
            node: index,
            parent,
            bounds,
            depth: depth(data, index),
            is_met: if is_leaf { in_leaf } else { node.is_inner() && went_down },
            is_leaf,
            listed: node.count(),
            inside: bounds.interval(self.origin, self.direction),
        });
    }
}

fn parent(data: &SceneData, node: u32) -> Option<u32> {
    let above = parent_of(*data.bvh_parents.get(node as usize)?);
    (above != NO_NODE).then_some(above)
}

fn depth(data: &SceneData, node: u32) -> u32 {
    above(data, node).count() as u32
}

/// The nodes above one, from its parent to the root.
pub(crate) fn above(data: &SceneData, node: u32) -> impl Iterator<Item = u32> + '_ {
    // Bounded, although no BVH that is built has a cycle.
    std::iter::successors(parent(data, node), |&above| parent(data, above)).take(data.bvh_parents.len())
}

/// The first leaf that lists a triangle.
pub(crate) fn leaf_of(data: &SceneData, triangle: u32) -> Option<u32> {
    let at = data.bvh_items.iter().position(|&item| item == triangle)? as u32;
    let lists = |node: &BvhNode| node.count() > 0 && at.checked_sub(node.first).is_some_and(|i| i < node.count());
    data.bvh_nodes.iter().position(lists).map(|leaf| leaf as u32)
}
