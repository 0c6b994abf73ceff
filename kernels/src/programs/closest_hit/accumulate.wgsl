// Adds a sample to its block's mean, and asks for the next sample or copies the mean of all to color.
//
// The block's mean is moved towards the sample; the means of complete blocks are added up: see the twin for the reasons.

import package::constants::{LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{UNWRITTEN, DONE};
import package::live::{book, tiled_texel};
import package::samples::{sampling};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@group(0) @binding(4) var color: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(5) var accumulated: texture_storage_2d_array<r32float, read_write>;
@if(blocks) @group(0) @binding(6) var blocks: texture_storage_2d_array<r32float, read_write>;

// Samples that have their own mean before it is added to the pixel's.
@if(blocks) const BLOCK: u32 = 16u;

fn add_sample(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let before = textureLoad(accumulated, texel, 4).x;
    if (textureLoad(state, texel, 0).x != DONE || before >= f32(sampling.samples)) {
        return NOBODY;
    }

    let samples = before + 1.0;
    @if(blocks) let of_block = f32(u32(before) % BLOCK + 1u);
    @else let of_block = samples;
    let is_hit = textureLoad(hit, texel, 2, 0).x != NO_TRIANGLE;
    let sample = vec4f(
        textureLoad(color, texel, 0).x,
        textureLoad(color, texel, 1).x,
        textureLoad(color, texel, 2).x,
        select(0.0, 1.0, is_hit),
    );
    let stored = vec4f(
        textureLoad(accumulated, texel, 0).x,
        textureLoad(accumulated, texel, 1).x,
        textureLoad(accumulated, texel, 2).x,
        textureLoad(accumulated, texel, 3).x,
    );
    @if(blocks) let mean_before = select(stored, vec4f(0.0), of_block == 1.0);
    @else let mean_before = stored;
    let mean = mean_before + (sample - mean_before) / of_block;
    textureStore(accumulated, texel, 0, vec4f(mean.x));
    textureStore(accumulated, texel, 1, vec4f(mean.y));
    textureStore(accumulated, texel, 2, vec4f(mean.z));
    textureStore(accumulated, texel, 3, vec4f(mean.w));
    textureStore(accumulated, texel, 4, vec4f(samples));
    @if(blocks) let sum = add_to_blocks(texel, mean, of_block);
    if (samples < f32(sampling.samples)) {
        textureStore(state, texel, 0, vec4u(UNWRITTEN));
        return UNWRITTEN;
    }
    @if(blocks) let all = mean_of_blocks(sum, mean, u32(samples));
    @else let all = mean;
    textureStore(color, texel, 0, vec4f(all.x));
    textureStore(color, texel, 1, vec4f(all.y));
    textureStore(color, texel, 2, vec4f(all.z));
    return DONE;
}

// The sum of the means of complete blocks, to which a block's mean is added with its last sample.
@if(blocks)
fn add_to_blocks(texel: vec2u, mean: vec4f, of_block: f32) -> vec4f {
    let before = vec4f(
        textureLoad(blocks, texel, 0).x,
        textureLoad(blocks, texel, 1).x,
        textureLoad(blocks, texel, 2).x,
        textureLoad(blocks, texel, 3).x,
    );
    let sum = before + select(vec4f(0.0), mean, of_block == f32(BLOCK));
    textureStore(blocks, texel, 0, vec4f(sum.x));
    textureStore(blocks, texel, 1, vec4f(sum.y));
    textureStore(blocks, texel, 2, vec4f(sum.z));
    textureStore(blocks, texel, 3, vec4f(sum.w));
    return sum;
}

// The mean of complete blocks, and of one that is not by its share.
@if(blocks)
fn mean_of_blocks(sum: vec4f, mean: vec4f, samples: u32) -> vec4f {
    let complete = f32(samples / BLOCK);
    let part = f32(samples % BLOCK) / f32(BLOCK);
    return (sum + select(vec4f(0.0), mean * part, part > 0.0)) / (complete + part);
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn accumulate(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, add_sample(tiled_texel(group, lane)));
}
