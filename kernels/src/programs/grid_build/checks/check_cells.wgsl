// Counts cells whose box is empty or leaves the grid, or whose list does not exist or has no end.

import package::counting::{end_of, first_of, store_faults};
import package::launch::{BLOCK, block_index};
import package::build::{build};
import package::leaf::{load};

@group(0) @binding(0) var cell: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var item: texture_2d_array<u32>;
@group(0) @binding(3) var totals: texture_2d_array<u32>;

const NO_LIST: u32 = 0xffffffffu;
const LAST_ITEM: u32 = 0x80000000u;

fn is_wrong(i: u32) -> bool {
    let a = load(cell, i, 0u);
    let b = load(cell, i, 1u);
    let c = load(cell, i, 2u);
    let low = vec3u(a & 0xffffu, a >> 16u, b & 0xffffu);
    let high = vec3u(b >> 16u, c & 0xffffu, c >> 16u);
    if (any(low >= high) || any(high > (build.cells << vec3u(build.levels)))) {
        return true;
    }
    let first = load(cell, i, 3u);
    if (first == NO_LIST) {
        return load(list, i, 1u) != 0u;
    }
    // The first item and the last one: what is in between ends there at the latest.
    let last = first + load(list, i, 1u) - 1u;
    let references = load(totals, 0u, 1u);
    return first >= references || last < first || last >= references || (load(item, last, 0u) & LAST_ITEM) == 0u;
}

@compute @workgroup_size(BLOCK)
fn check_cells(
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
