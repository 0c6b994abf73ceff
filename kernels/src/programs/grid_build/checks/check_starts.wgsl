// Counts lists that end before they start, or beyond the references.

import package::counting::{end_of, first_of, store_faults};
import package::launch::{BLOCK, launch, block_index};
import package::leaf::{load};

@group(0) @binding(0) var start: texture_2d_array<u32>;
@group(0) @binding(1) var references_in_all: texture_2d_array<u32>;

fn is_wrong(i: u32) -> bool {
    var end = load(references_in_all, 0u, 0u);
    if (i + 1u < launch.elements) {
        end = load(start, i + 1u, 0u);
    }
    return load(start, i, 0u) > end || end > load(references_in_all, 0u, 0u);
}

@compute @workgroup_size(BLOCK)
fn check_starts(
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
