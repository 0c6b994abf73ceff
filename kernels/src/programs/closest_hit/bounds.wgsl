// What is certain of the nearest hit of a ray that takes its steps in several passes.

import package::constants::{INF};
import package::state::{EXACT, SHADE, BACKGROUND};

@if(exact_order) @group(0) @binding(14) var bounds: texture_storage_2d_array<r32float, read_write>;

// The largest t that the hit may have whose t is stored.
fn latest_of(texel: vec2u, t: f32) -> f32 {
    @if(exact_order) return t + textureLoad(bounds, texel, 0).x;
    @else return t;
}

// The state of a ray that goes to the state `tag` if its hit is certain.
fn ended_with(texel: vec2u, tag: u32, t: f32) -> u32 {
    @if(exact_order) if (tag == SHADE || tag == BACKGROUND) {
        let open = textureLoad(bounds, texel, 1).x;
        if (open <= latest_of(texel, t) && open < INF) {
            return EXACT;
        }
    }
    return tag;
}

// A ray without a hit so far.
fn reset_bounds(texel: vec2u) {
    @if(exact_order) {
        textureStore(bounds, texel, 0, vec4f(0.0));
        textureStore(bounds, texel, 1, vec4f(INF));
    }
}
