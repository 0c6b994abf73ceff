// Finds in which halves of its leaf each reference lies, if the leaf may be divided; counts them in groups of 32.

import package::launch::{BLOCK, launch, block_index, texel};
import package::leaf::{load, load_space, level_of, low_of};
import package::candidate::{may_be_divided};
import package::halves::{NOT_CERTAIN, certain_halves, halves};
import package::build::{build};

@group(0) @binding(0) var owner: texture_2d_array<u32>;
@group(0) @binding(1) var item: texture_2d_array<u32>;
@group(0) @binding(2) var space: texture_2d_array<u32>;
@group(0) @binding(3) var list: texture_2d_array<u32>;
@group(0) @binding(4) var division: texture_2d_array<u32>;
@group(0) @binding(5) var bits: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(6) var tally: texture_storage_2d_array<r32uint, write>;

const GROUPS: u32 = BLOCK / 32u;

// For each group and half, a bit for each reference.
var<workgroup> lying_in: array<atomic<u32>, 8u * GROUPS>;
// Threads whose references are not certain, in any order: what they find does not depend on it.
var<workgroup> waiting: array<u32, BLOCK>;
var<workgroup> waiting_count: atomic<u32>;

fn note(lane: u32, halves_found: u32) {
    var mask = halves_found;
    // At most 8 turns.
    while (mask != 0u) {
        let half = firstTrailingBit(mask);
        atomicOr(&lying_in[8u * (lane / 32u) + half], 1u << (lane % 32u));
        mask &= mask - 1u;
    }
}

fn cell_of_leaf(leaf: u32, level: u32) -> vec3u {
    let extent = load_space(space, leaf);
    return vec3u(low_of(extent.x), low_of(extent.y), low_of(extent.z)) >> vec3u(build.levels - level);
}

@compute @workgroup_size(BLOCK)
fn halve(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    let i = block * BLOCK + lane;
    if (lane < 8u * GROUPS) {
        atomicStore(&lying_in[lane], 0u);
    }
    if (lane == 0u) {
        atomicStore(&waiting_count, 0u);
    }
    workgroupBarrier();
    if (i < launch.elements) {
        let leaf = load(owner, i, 0u);
        let levels = load(division, leaf, 1u);
        if (may_be_divided(levels, load(list, leaf, 1u))) {
            let level = level_of(levels);
            let mask = certain_halves(load(item, i, 0u), cell_of_leaf(leaf, level), level + 1u);
            if (mask == NOT_CERTAIN) {
                waiting[atomicAdd(&waiting_count, 1u)] = lane;
            } else {
                note(lane, mask);
            }
        }
    }
    workgroupBarrier();
    // Those that wait are few: side by side, they keep few threads busy for long.
    if (lane < atomicLoad(&waiting_count)) {
        let waiter = waiting[lane];
        let leaf = load(owner, block * BLOCK + waiter, 0u);
        let level = level_of(load(division, leaf, 1u));
        note(waiter, halves(load(item, block * BLOCK + waiter, 0u), cell_of_leaf(leaf, level), level + 1u));
    }
    workgroupBarrier();
    let its_group = block * GROUPS + lane / 8u;
    if (lane < 8u * GROUPS && 32u * its_group < launch.elements) {
        let found = atomicLoad(&lying_in[lane]);
        let at = texel(its_group, textureDimensions(bits).x);
        textureStore(bits, at, lane % 8u, vec4u(found));
        textureStore(tally, at, lane % 8u, vec4u(countOneBits(found)));
    }
}
