// Counts the faults that the threads of a workgroup find among its elements, 32 a thread.

import package::launch::{BLOCK, launch, texel};

@group(0) @binding(15) var faults: texture_storage_2d_array<r32uint, write>;

// Elements per thread.
const EACH: u32 = 32u;

var<workgroup> found: atomic<u32>;

// The first element of a workgroup, and the one after its last.
fn first_of(block: u32) -> u32 {
    return block * BLOCK * EACH;
}

fn end_of(block: u32) -> u32 {
    return min(first_of(block) + BLOCK * EACH, launch.elements);
}

// Stores the sum of what the threads have found.
fn store_faults(block: u32, lane: u32, own: u32) {
    if (lane == 0u) {
        atomicStore(&found, 0u);
    }
    workgroupBarrier();
    atomicAdd(&found, own);
    workgroupBarrier();
    if (lane == 0u && first_of(block) < launch.elements) {
        textureStore(faults, texel(block, textureDimensions(faults).x), 0, vec4u(atomicLoad(&found)));
    }
}
