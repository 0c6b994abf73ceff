// Moves the ray to its next cell of the irregular grid, the one behind the face by which it leaves the cell's box.

import package::constants::{INF, NOBODY, LIST_SIDE};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::ray::{load_origin, load_direction};
import package::grid_walk::{grid_ray};
import package::irregular_walk::{at_voxel, step_voxel};
import package::live::{send};
@if(live_lists) import package::live::{listed_texel};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, write>;
@if(counters) @group(0) @binding(4) var counters: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(5) var voxel: texture_storage_2d_array<r32uint, read_write>;

fn load_voxel(texel: vec2u) -> vec3i {
    return vec3i(vec3u(
        textureLoad(voxel, texel, 0).x,
        textureLoad(voxel, texel, 1).x,
        textureLoad(voxel, texel, 2).x,
    ));
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
    // A hit beyond the box's exit is kept; a later cell may hold a nearer one.
    @if(any_hit) let has_hit = false;
    @else let has_hit = nearest_t < INF;
    let walk = step_voxel(at_voxel(load_voxel(texel), textureLoad(state, texel, 2).x, ray), ray);

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
    textureStore(voxel, texel, 0, vec4u(u32(walk.voxel.x)));
    textureStore(voxel, texel, 1, vec4u(u32(walk.voxel.y)));
    textureStore(voxel, texel, 2, vec4u(u32(walk.voxel.z)));
    textureStore(state, texel, 2, vec4u(walk.cell));
    textureStore(state, texel, 3, vec4u(0u));
    return tag;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn traverse_irregular(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    @if(live_lists) let texel = listed_texel(group, lane);
    @else let texel = id.xy;
    send(lane, texel, step_cell(texel));
}
