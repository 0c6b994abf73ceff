// The walk through a binary tree without a stack, one node a step (after Hapala and others, 2011): the
// node and the one visited before it tell whether the ray enters the node or has finished with it.
//
// Boxes are grown on the host by more than the rounding of both tests, so the test here needs no epsilon.

import package::constants::{NO_NODE, TINY_DIRECTION};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};

struct BvhNode {
    min: vec3f,
    // Inner: the first of two children, which lie side by side; leaf: its first item.
    first: u32,
    max: vec3f,
    // Bits 30-31: axis along which the first child lies lower; bits 0-29: items of a leaf, 0 for an inner node.
    link: u32,
}

@group(1) @binding(17) var<storage, read> bvh_nodes: array<BvhNode>;
@group(1) @binding(18) var<storage, read> bvh_parents: array<u32>;

// 1 / direction, kept finite: a component too small to matter inside of the scene gets a size that
// cannot overflow.
fn finite_inverse(direction: vec3f) -> vec3f {
    let tiny = abs(direction) < vec3f(TINY_DIRECTION);
    let least = select(vec3f(TINY_DIRECTION), vec3f(-TINY_DIRECTION), direction < vec3f(0.0));
    return 1.0 / select(direction, least, tiny);
}

fn hits_box(node: BvhNode, origin: vec3f, inverse: vec3f, nearest_t: f32) -> bool {
    let t0 = (node.min - origin) * inverse;
    let t1 = (node.max - origin) * inverse;
    let enter = min(t0, t1);
    let leave = max(t0, t1);
    let t_enter = max(max(enter.x, enter.y), max(enter.z, 0.0));
    let t_leave = min(min(leave.x, leave.y), min(leave.z, nearest_t));
    return t_enter <= t_leave;
}

fn near_child(node: BvhNode, direction: vec3f) -> u32 {
    let axis = node.link >> 30u;
    let along = select(select(direction.z, direction.y, axis == 1u), direction.x, axis == 0u);
    return node.first + select(0u, 1u, along < 0.0);
}

struct Visit {
    node: u32,
    previous: u32,
    // In a leaf whose box the ray meets.
    in_leaf: bool,
}

// One step. A finished ray is at NO_NODE.
fn next_node(at: Visit, origin: vec3f, direction: vec3f, inverse: vec3f, nearest_t: f32) -> Visit {
    let node = bvh_nodes[at.node];
    let parent = bvh_parents[at.node];
    let enters = at.previous == parent;
    if (enters && hits_box(node, origin, inverse, nearest_t)) {
        if ((node.link & 0x3fffffffu) != 0u) {
            return Visit(at.node, at.node, true);
        }
        return Visit(near_child(node, direction), at.node, false);
    }
    // Finished here: on to the sibling if this was the nearer child, else up.
    if (parent == NO_NODE) {
        return Visit(NO_NODE, at.node, false);
    }
    let above = bvh_nodes[parent];
    if (at.node == near_child(above, direction)) {
        return Visit(2u * above.first + 1u - at.node, parent, false);
    }
    return Visit(parent, at.node, false);
}
