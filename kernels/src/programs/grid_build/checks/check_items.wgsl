// Counts references to triangles that do not exist.

import package::counting::{end_of, first_of, store_faults};
import package::launch::{BLOCK, block_index};
import package::build::{build};
import package::leaf::{load};

@group(0) @binding(0) var item: texture_2d_array<u32>;

// Bit 31 marks the last one of a list.
const TRIANGLE: u32 = 0x7fffffffu;

fn is_wrong(i: u32) -> bool {
    return (load(item, i, 0u) & TRIANGLE) >= build.triangles;
}

@compute @workgroup_size(BLOCK)
fn check_items(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    var own = 0u;
    for (var i = first_of(block) + lane; i < end_of(block); i += BLOCK) {
        own += u32(is_wrong(i));
    }
    store_faults(block, lane, own);
}
