// What a step from cell to cell leaves in the streams.

import package::constants::{INF};
import package::state::{ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@if(grid && !dda) @group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, read_write>;
@if(dda) @group(0) @binding(3) var control: texture_storage_2d_array<r32float, read_write>;
@if(irregular) @group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, write>;
@if(counters) @group(0) @binding(4) var counters: texture_storage_2d_array<r32uint, read_write>;

// Whether the ray has a hit. One beyond the exit of its cell is kept; a later cell may hold a nearer one.
fn keeps_hit(texel: vec2u) -> bool {
    @if(any_hit) return false;
    @else return bitcast<f32>(textureLoad(state, texel, 1).x) < INF;
}

// The ray has left the grid.
fn leave(texel: vec2u) -> u32 {
    let ended = select(BACKGROUND, SHADE, keeps_hit(texel));
    textureStore(state, texel, 0, vec4u(ended));
    return ended;
}

// The ray is in a cell; `per_axis` decides by which face it leaves it.
fn arrive(texel: vec2u, cell: u32, per_axis: vec3f) -> u32 {
    @if(counters) textureStore(counters, texel, 0, vec4u(textureLoad(counters, texel, 0).x + 1u));
    let tag = select(ISECT_NO_HIT, ISECT_HIT, keeps_hit(texel));
    textureStore(state, texel, 0, vec4u(tag));
    @if(!dda) {
        textureStore(tmax, texel, 0, vec4f(per_axis.x));
        textureStore(tmax, texel, 1, vec4f(per_axis.y));
        textureStore(tmax, texel, 2, vec4f(per_axis.z));
    }
    @if(dda) {
        textureStore(control, texel, 0, vec4f(per_axis.x));
        textureStore(control, texel, 1, vec4f(per_axis.y));
        textureStore(control, texel, 2, vec4f(per_axis.z));
    }
    textureStore(state, texel, 2, vec4u(cell));
    textureStore(state, texel, 3, vec4u(0u));
    return tag;
}
