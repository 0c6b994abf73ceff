// Moves each pair of key and value to its place by one digit of the key; pairs with the same digit keep their order.
//
// A pair's rank in its block is counted from one bit per thread and digit, like the ballots of a warp (Ashkiani,
// Davidson, Meyer, Owens 2016). The result does not depend on the order in which the bits are set.

import package::launch::{BLOCK, launch, block_index, texel};
import package::radix::{DIGITS, digit_of, tally_index};

@group(0) @binding(0) var key_in: texture_2d_array<u32>;
@group(0) @binding(1) var value_in: texture_2d_array<u32>;
@group(0) @binding(2) var tally: texture_2d_array<u32>;
@group(0) @binding(3) var key_out: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var value_out: texture_storage_2d_array<r32uint, write>;

const LANE_WORDS: u32 = BLOCK / 32u;

// For each digit, a bit for each thread whose key has it.
var<workgroup> having: array<atomic<u32>, DIGITS * LANE_WORDS>;

@compute @workgroup_size(BLOCK)
fn scatter(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    let i = block * BLOCK + lane;
    if (lane < DIGITS * LANE_WORDS) {
        atomicStore(&having[lane], 0u);
    }
    workgroupBarrier();
    var key = 0u;
    let word = lane / 32u;
    let bit = 1u << (lane % 32u);
    if (i < launch.elements) {
        key = textureLoad(key_in, texel(i, textureDimensions(key_in).x), 0, 0).x;
        atomicOr(&having[digit_of(key) * LANE_WORDS + word], bit);
    }
    workgroupBarrier();
    if (i >= launch.elements) {
        return;
    }
    let digit = digit_of(key);
    let own = digit * LANE_WORDS;
    var rank = countOneBits(atomicLoad(&having[own + word]) & (bit - 1u));
    for (var before = 0u; before < word; before++) {
        rank += countOneBits(atomicLoad(&having[own + before]));
    }
    let first = textureLoad(tally, texel(tally_index(digit, block), textureDimensions(tally).x), 0, 0).x;
    let to = texel(first + rank, textureDimensions(key_out).x);
    let source = texel(i, textureDimensions(value_in).x);
    textureStore(key_out, to, 0, vec4u(key));
    for (var layer = 0u; layer < textureNumLayers(value_in); layer++) {
        textureStore(value_out, to, layer, textureLoad(value_in, source, layer, 0));
    }
}
