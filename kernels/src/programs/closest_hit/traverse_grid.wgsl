// Moves the ray to its next cell, the one behind the face that it reaches first, or past a cube of empty cells if their
// distances are known.

import package::constants::{INF, NOBODY, LIST_SIDE};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::ray::{load_origin, load_direction};
import package::grid_walk::{Walk, grid_ray, advance, cell_index, cell_of_index};
@if(skip) import package::grid_walk::{leap};
@if(skip) import package::grid_lists::{empty_distance};
import package::live::{send};
@if(live_lists) import package::live::{listed_texel};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, read_write>;
@if(counters) @group(0) @binding(4) var counters: texture_storage_2d_array<r32uint, read_write>;

fn load_tmax(texel: vec2u) -> vec3f {
    return vec3f(
        textureLoad(tmax, texel, 0).x,
        textureLoad(tmax, texel, 1).x,
        textureLoad(tmax, texel, 2).x,
    );
}

fn step_cell(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV) {
        return NOBODY;
    }

    let ray = grid_ray(load_origin(texel), load_direction(texel));
    let nearest_t = bitcast<f32>(textureLoad(state, texel, 1).x);
    // A hit beyond the cell's exit is kept; a later cell may hold a nearer one.
    @if(any_hit) let has_hit = false;
    @else let has_hit = nearest_t < INF;
    let index = textureLoad(state, texel, 2).x;
    var walk = Walk(cell_of_index(index), load_tmax(texel), true);
    @if(skip) walk = leap(walk, max(empty_distance(index), 1), ray);
    @else walk = advance(walk, ray);

    if (!walk.inside) {
        let ended = select(BACKGROUND, SHADE, has_hit);
        textureStore(state, texel, 0, vec4u(ended));
        return ended;
    }
    @if(counters) textureStore(counters, texel, 0, vec4u(textureLoad(counters, texel, 0).x + 1u));
    let tag = select(ISECT_NO_HIT, ISECT_HIT, has_hit);
    textureStore(state, texel, 0, vec4u(tag));
    textureStore(tmax, texel, 0, vec4f(walk.tmax.x));
    textureStore(tmax, texel, 1, vec4f(walk.tmax.y));
    textureStore(tmax, texel, 2, vec4f(walk.tmax.z));
    textureStore(state, texel, 2, vec4u(cell_index(walk.cell)));
    textureStore(state, texel, 3, vec4u(0u));
    return tag;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn traverse_grid(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    @if(live_lists) let texel = listed_texel(group, lane);
    @else let texel = id.xy;
    send(lane, texel, step_cell(texel));
}
