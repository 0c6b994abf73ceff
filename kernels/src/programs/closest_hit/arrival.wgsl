// What a step from cell to cell leaves in the streams.

import package::constants::{INF};
import package::state::{ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::bounds::{ended_with};
import package::per_axis::{store_per_axis};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, read_write>;

// Whether the ray has a hit. One beyond the exit of its cell is kept; a later cell may hold a nearer one.
fn keeps_hit(texel: vec2u) -> bool {
    @if(any_hit) return false;
    @else return bitcast<f32>(textureLoad(state, texel, 1).x) < INF;
}

// The ray has left the grid.
fn leave(texel: vec2u) -> u32 {
    let tag = select(BACKGROUND, SHADE, keeps_hit(texel));
    @if(exact_order) let ended = ended_with(texel, tag, bitcast<f32>(textureLoad(state, texel, 1).x));
    @else let ended = tag;
    textureStore(state, texel, 0, vec4u(ended));
    return ended;
}

// The ray is in a cell; `along` decides by which face it leaves it.
fn arrive(texel: vec2u, cell: u32, along: vec3f) -> u32 {
    @if(counters) textureStore(counters, texel, 0, vec4u(textureLoad(counters, texel, 0).x + 1u));
    let tag = select(ISECT_NO_HIT, ISECT_HIT, keeps_hit(texel));
    textureStore(state, texel, 0, vec4u(tag));
    store_per_axis(texel, along);
    textureStore(state, texel, 2, vec4u(cell));
    textureStore(state, texel, 3, vec4u(0u));
    return tag;
}
