//! The walk through the BVH: a node's box, and where the ray continues.

use super::super::states;
use super::listing;
use crate::program::RayState;
use crate::scene_data::SceneData;
use crate::shared::bvh_walk::parent_of;
use crate::shared::constants::NO_NODE;

/// One step between nodes. Whether the ray meets the node's box is inferred from where it went.
pub(super) fn explain_node(data: &SceneData, before: &RayState, after: &RayState) -> String {
    let (at, to) = (before.cell_index, after.cell_index);
    let parent = |node: u32| data.bvh_parents.get(node as usize).map_or(NO_NODE, |&above| parent_of(above));
    let is_entered = matches!(after.tag, states::ISECT_HIT | states::ISECT_NO_HIT);
    let goes_down = after.tag == states::TRAV && to != at && parent(to) == at;
    let next = match after.tag {
        states::BACKGROUND => "the tree is done; nothing hit".into(),
        states::SHADE => "the tree is done; the kept hit is the nearest".into(),
        _ if is_entered => {
            format!("a leaf, {}", listing(data.bvh_nodes.get(at as usize).map_or(0, |node| node.count() as usize)))
        }
        _ if goes_down => format!("down to node {to}, the nearer child"),
        _ if to == parent(at) => format!("up to node {to}"),
        _ => format!("on to node {to}, the sibling"),
    };
    if before.previous != Some(parent(at)) {
        return format!("node {at} is done: {next}");
    }
    let is_met = match (is_entered || goes_down, before.t, before.triangle) {
        (true, ..) => "met",
        (false, None, _) => "missed",
        (false, Some(_), None) => "missed, or beyond the ray's end",
        (false, Some(_), Some(_)) => "missed, or beyond the nearest hit",
    };
    format!("node {at}: its box is {is_met}: {next}")
}
