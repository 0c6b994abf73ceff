// Counts how often each value of a digit occurs in a block of keys.

import package::launch::{BLOCK, launch, block_index, texel};
import package::radix::{DIGITS, digit_of, tally_index};

@group(0) @binding(0) var key_in: texture_2d_array<u32>;
@group(0) @binding(1) var tally: texture_storage_2d_array<r32uint, write>;

var<workgroup> counts: array<atomic<u32>, DIGITS>;

@compute @workgroup_size(BLOCK)
fn histogram(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    let i = block * BLOCK + lane;
    if (lane < DIGITS) {
        atomicStore(&counts[lane], 0u);
    }
    workgroupBarrier();
    if (i < launch.elements) {
        let key = textureLoad(key_in, texel(i, textureDimensions(key_in).x), 0, 0).x;
        atomicAdd(&counts[digit_of(key)], 1u);
    }
    workgroupBarrier();
    // A dispatch may have workgroups past the last block.
    if (block < launch.blocks && lane < DIGITS) {
        let to = texel(tally_index(lane, block), textureDimensions(tally).x);
        textureStore(tally, to, 0, vec4u(atomicLoad(&counts[lane])));
    }
}
