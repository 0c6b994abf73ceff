// Moves the ray to its next node of the BVH, or into the leaf that it is at, or ends its walk.

import package::constants::{INF, NOBODY, NO_NODE, LIST_SIDE};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::ray::{load_origin, load_direction, load_interval};
import package::bounds::{ended_with, latest_of};
import package::bvh_walk::{Visit, next_node, finite_inverse};
import package::live::{send, listed_texel};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var previous: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(4) var counters: texture_storage_2d_array<r32uint, read_write>;

fn step_node(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV) {
        return NOBODY;
    }

    let origin = load_origin(texel);
    let direction = load_direction(texel);
    let nearest_t = bitcast<f32>(textureLoad(state, texel, 1).x);
    @if(any_hit) let has_hit = false;
    @else let has_hit = nearest_t < INF;
    let here = Visit(textureLoad(state, texel, 2).x, textureLoad(previous, texel, 0).x, false);
    @if(intervals) let farthest = min(latest_of(texel, nearest_t), load_interval(texel).y);
    @else let farthest = latest_of(texel, nearest_t);
    let at = next_node(here, origin, direction, finite_inverse(direction), farthest);

    @if(counters) textureStore(counters, texel, 0, vec4u(textureLoad(counters, texel, 0).x + 1u));
    if (at.node == NO_NODE) {
        let ended = ended_with(texel, select(BACKGROUND, SHADE, has_hit), nearest_t);
        textureStore(state, texel, 0, vec4u(ended));
        return ended;
    }
    let tag = select(TRAV, select(ISECT_NO_HIT, ISECT_HIT, has_hit), at.in_leaf);
    textureStore(state, texel, 0, vec4u(tag));
    textureStore(state, texel, 2, vec4u(at.node));
    textureStore(state, texel, 3, vec4u(0u));
    textureStore(previous, texel, 0, vec4u(at.previous));
    return tag;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn traverse_bvh(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    @if(live_lists) let texel = listed_texel(group, lane);
    @else let texel = id.xy;
    send(lane, texel, step_node(texel));
}
