// Counts entries of the voxel map that lead to no cell, to no block, or back: a block lies after its entry, so that every way
// through the map ends.

import package::counting::{end_of, first_of, store_faults};
import package::launch::{BLOCK, launch, block_index};
import package::build::{build};
import package::leaf::{load};

@group(0) @binding(0) var map_entries: texture_2d_array<u32>;
@group(0) @binding(1) var totals: texture_2d_array<u32>;
@group(0) @binding(2) var entries_in_all: texture_2d_array<u32>;

fn is_wrong(i: u32) -> bool {
    let entry = load(map_entries, i, 0u);
    let levels = entry & 3u;
    if (levels == 0u) {
        return (entry >> 2u) >= load(totals, 0u, 0u);
    }
    let cells = build.cells.x * build.cells.y * build.cells.z;
    // The blocks' entries follow those of the top level.
    let own = i + select(0u, cells, launch.parameter == 1u);
    let begin = entry >> 2u;
    return begin <= own || begin + (1u << (3u * levels)) > cells + load(entries_in_all, 0u, 0u);
}

@compute @workgroup_size(BLOCK)
fn check_map(
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
