// Advances each ray by up to K steps: a step is a cell, or eight nodes, with all of their triangles. Does what traverse
// and intersect do one step at a time, with the ray kept in registers. The loop over the steps is in the file of the
// structure that the scene is traced through: walk/grid.wgsl, irregular.wgsl, bvh.wgsl or all.wgsl.
//
// resumes: with long lists, K steps may take more loop iterations than a dispatch allows. The ray then waits before a
// step, or at an item of its list.

import package::constants::{NOBODY, LIST_SIDE};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, EXACT, SHADE, BACKGROUND};
import package::ray::{load_ray};
import package::bounds::{bounds};
import package::tracing::{is_open, new_trace};
import package::live::{listed_texel, send};
import package::walk_place::{Place};
import package::walk_structure::{walked};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, read_write>;

fn take_steps(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    var place: Place;
    place.tag = textureLoad(state, texel, 0).x;
    if (place.tag != TRAV && place.tag != ISECT_NO_HIT && place.tag != ISECT_HIT) {
        return NOBODY;
    }
    place.cell = textureLoad(state, texel, 2).x;
    @if(resumes || (!grid && !irregular && !bvh)) place.item = textureLoad(state, texel, 3).x;
    place.trace = new_trace(texel, load_ray(texel), bitcast<f32>(textureLoad(state, texel, 1).x));
    place.trace.triangle = textureLoad(hit, texel, 2).x;
    @if(exact_order) place.trace.error = textureLoad(bounds, texel, 0).x;
    @if(exact_order) place.trace.open = textureLoad(bounds, texel, 1).x;
    let t_before = place.trace.t;
    let triangle_before = place.trace.triangle;

    place = walked(place, texel);

    if (place.trace.triangle != triangle_before || place.trace.t != t_before) {
        textureStore(hit, texel, 0, vec4u(bitcast<u32>(place.trace.u)));
        textureStore(hit, texel, 1, vec4u(bitcast<u32>(place.trace.v)));
        textureStore(hit, texel, 2, vec4u(place.trace.triangle));
        textureStore(state, texel, 1, vec4u(bitcast<u32>(place.trace.t)));
    }
    @if(exact_order) {
        textureStore(bounds, texel, 0, vec4f(place.trace.error));
        textureStore(bounds, texel, 1, vec4f(place.trace.open));
        if ((place.tag == SHADE || place.tag == BACKGROUND) && is_open(place.trace)) {
            place.tag = EXACT;
        }
    }
    textureStore(state, texel, 0, vec4u(place.tag));
    @if(grid || irregular || bvh) textureStore(state, texel, 2, vec4u(place.cell));
    @if(resumes || (!grid && !irregular && !bvh)) textureStore(state, texel, 3, vec4u(place.item));
    @if(counters) {
        textureStore(counters, texel, 0, vec4u(textureLoad(counters, texel, 0).x + place.trace.cells));
        textureStore(counters, texel, 1, vec4u(textureLoad(counters, texel, 1).x + place.trace.tests));
    }
    return place.tag;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn walk(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let texel = listed_texel(group, lane);
    send(lane, texel, take_steps(texel));
}
