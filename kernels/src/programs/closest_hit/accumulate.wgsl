// Adds a sample to its pixel's mean, and asks for the next sample or copies the mean to color.
//
// The mean is moved towards the sample; there is no sum to divide at the end: see the twin for the reason.

import package::constants::{LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{UNWRITTEN, DONE};
import package::live::{book, tiled_texel};
import package::samples::{sampling};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@group(0) @binding(4) var color: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(5) var accumulated: texture_storage_2d_array<r32float, read_write>;

fn add_sample(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let before = textureLoad(accumulated, texel, 4).x;
    if (textureLoad(state, texel, 0).x != DONE || before >= f32(sampling.samples)) {
        return NOBODY;
    }

    let samples = before + 1.0;
    let is_hit = textureLoad(hit, texel, 2, 0).x != NO_TRIANGLE;
    let sample = vec4f(
        textureLoad(color, texel, 0).x,
        textureLoad(color, texel, 1).x,
        textureLoad(color, texel, 2).x,
        select(0.0, 1.0, is_hit),
    );
    let mean_before = vec4f(
        textureLoad(accumulated, texel, 0).x,
        textureLoad(accumulated, texel, 1).x,
        textureLoad(accumulated, texel, 2).x,
        textureLoad(accumulated, texel, 3).x,
    );
    let mean = mean_before + (sample - mean_before) / samples;
    textureStore(accumulated, texel, 0, vec4f(mean.x));
    textureStore(accumulated, texel, 1, vec4f(mean.y));
    textureStore(accumulated, texel, 2, vec4f(mean.z));
    textureStore(accumulated, texel, 3, vec4f(mean.w));
    textureStore(accumulated, texel, 4, vec4f(samples));
    if (samples < f32(sampling.samples)) {
        textureStore(state, texel, 0, vec4u(UNWRITTEN));
        return UNWRITTEN;
    }
    textureStore(color, texel, 0, vec4f(mean.x));
    textureStore(color, texel, 1, vec4f(mean.y));
    textureStore(color, texel, 2, vec4f(mean.z));
    return DONE;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn accumulate(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, add_sample(tiled_texel(group, lane)));
}
