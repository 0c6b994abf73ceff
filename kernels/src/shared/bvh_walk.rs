//! Twin of `bvh_walk.wgsl`: one step through the binary tree, without a stack.

use super::constants::{NO_NODE, PARALLEL};
use crate::bvh::BvhNode;
use crate::real::{Real, Vec3};

/// A ray's place in the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visit {
    /// The node; [`NO_NODE`] for a ray that has finished.
    pub node: u32,
    /// The node before it; the node itself for a leaf that is done.
    pub previous: u32,
    /// In a leaf whose box the ray meets.
    pub in_leaf: bool,
}

/// 1 / direction, kept finite: a component too small to matter inside of the scene gets a size that
/// cannot overflow.
pub fn finite_inverse<R: Real>(direction: Vec3<R>) -> Vec3<R> {
    let least = R::from_f32(PARALLEL);
    direction.map(|d| {
        let d = if d.abs() < least { if d < R::zero() { -least } else { least } } else { d };
        R::one() / d
    })
}

/// Whether the ray is in the node's box anywhere between 0 and `nearest_t`.
pub fn hits_box<R: Real>(node: &BvhNode, origin: Vec3<R>, inverse: Vec3<R>, nearest_t: R) -> bool {
    let t0 = (Vec3::from_f32(node.min) - origin) * inverse;
    let t1 = (Vec3::from_f32(node.max) - origin) * inverse;
    let t_enter = t0.x.min(t1.x).max(t0.y.min(t1.y)).max(t0.z.min(t1.z).max(R::zero()));
    let t_leave = t0.x.max(t1.x).min(t0.y.max(t1.y)).min(t0.z.max(t1.z).min(nearest_t));
    t_enter <= t_leave
}

/// The child that the ray should visit first.
pub fn near_child<R: Real>(node: &BvhNode, direction: Vec3<R>) -> u32 {
    let along = match node.link >> 30 {
        0 => direction.x,
        1 => direction.y,
        _ => direction.z,
    };
    node.first.wrapping_add(u32::from(along < R::zero()))
}

/// One step (after Hapala and others, 2011).
pub fn next_node<R: Real>(
    nodes: &[BvhNode],
    parents: &[u32],
    at: Visit,
    origin: Vec3<R>,
    direction: Vec3<R>,
    inverse: Vec3<R>,
    nearest_t: R,
) -> Visit {
    let node = &nodes[at.node as usize];
    let parent = parents[at.node as usize];
    if at.previous == parent && hits_box(node, origin, inverse, nearest_t) {
        if node.count() != 0 {
            return Visit { node: at.node, previous: at.node, in_leaf: true };
        }
        return Visit { node: near_child(node, direction), previous: at.node, in_leaf: false };
    }
    // Finished here: on to the sibling if this was the nearer child, else up.
    if parent == NO_NODE {
        return Visit { node: NO_NODE, previous: at.node, in_leaf: false };
    }
    let above = &nodes[parent as usize];
    if at.node == near_child(above, direction) {
        return Visit { node: 2 * above.first + 1 - at.node, previous: parent, in_leaf: false };
    }
    Visit { node: parent, previous: at.node, in_leaf: false }
}
