// The walk through a binary BVH without a stack, one node per step (after Hapala and others, 2011): the node and the
// previous one tell whether the ray enters the node or has finished with it.
//
// Boxes are grown by more than the rounding errors of both tests: on the host, so that the test here needs no epsilon;
// or, in a scene whose reach is large compared with its triangles, here, in proportion to the box's distance.

import package::constants::{NO_NODE, TINY_DIRECTION, BOX_PADDING};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};

struct BvhNode {
    min: vec3f,
    // Inner node: the first of two adjacent children; leaf: its first item.
    first: u32,
    max: vec3f,
    // Bits 30-31: axis along which the first child is the lower one; bits 0-29: items of a leaf, 0 for an inner node.
    link: u32,
}

@group(1) @binding(17) var<storage, read> bvh_nodes: array<BvhNode>;
// The parent, and in bits 30-31 the axis of its link; NO_NODE for the root.
@group(1) @binding(18) var<storage, read> bvh_parents: array<u32>;

// 1 / direction, kept finite: a component too small to matter inside the scene is replaced by one whose inverse cannot
// overflow.
fn finite_inverse(direction: vec3f) -> vec3f {
    let tiny = abs(direction) < vec3f(TINY_DIRECTION);
    let least = select(vec3f(TINY_DIRECTION), vec3f(-TINY_DIRECTION), direction < vec3f(0.0));
    return 1.0 / select(direction, least, tiny);
}

fn hits_box(node: BvhNode, origin: vec3f, inverse: vec3f, nearest_t: f32) -> bool {
    let low = node.min - origin;
    let high = node.max - origin;
    @if(ray_padding) let far = max(abs(low), abs(high));
    @if(ray_padding) let padding = BOX_PADDING * max(max(far.x, far.y), far.z);
    @if(ray_padding) let t0 = (low - padding) * inverse;
    @if(ray_padding) let t1 = (high + padding) * inverse;
    @if(!ray_padding) let t0 = low * inverse;
    @if(!ray_padding) let t1 = high * inverse;
    let enter = min(t0, t1);
    let leave = max(t0, t1);
    let t_enter = max(max(enter.x, enter.y), max(enter.z, 0.0));
    let t_leave = min(min(leave.x, leave.y), min(leave.z, nearest_t));
    return t_enter <= t_leave;
}

// Whether the ray goes down along an axis (0 to 2).
fn goes_down(axis: u32, direction: vec3f) -> bool {
    return select(select(direction.z, direction.y, axis == 1u), direction.x, axis == 0u) < 0.0;
}

struct Visit {
    node: u32,
    previous: u32,
    // Whether the ray is in a leaf whose box it meets.
    in_leaf: bool,
}

// One step. A finished ray is at NO_NODE.
fn next_node(at: Visit, origin: vec3f, direction: vec3f, inverse: vec3f, nearest_t: f32) -> Visit {
    let above = bvh_parents[at.node];
    let parent = select(above & 0x3fffffffu, NO_NODE, above == NO_NODE);
    if (at.previous == parent) {
        let node = bvh_nodes[at.node];
        if (hits_box(node, origin, inverse, nearest_t)) {
            if ((node.link & 0x3fffffffu) != 0u) {
                return Visit(at.node, at.node, true);
            }
            let nearer = node.first + select(0u, 1u, goes_down(node.link >> 30u, direction));
            return Visit(nearer, at.node, false);
        }
    }
    // Finished with this node: continue with the sibling if this was the nearer child, else with the parent.
    if (parent == NO_NODE) {
        return Visit(NO_NODE, at.node, false);
    }
    // The first of two siblings has an odd index.
    let is_first = (at.node & 1u) == 1u;
    if (is_first != goes_down(above >> 30u, direction)) {
        return Visit(((at.node - 1u) ^ 1u) + 1u, parent, false);
    }
    return Visit(parent, at.node, false);
}
