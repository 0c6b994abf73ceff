// Finds in which halves of its leaf each reference lies, if the leaf may be divided; counts them in groups of 32.

import package::launch::{BLOCK, launch, block_index, texel};
import package::leaf::{load_at, place_in, space_at, level_of, low_of};
import package::candidate::{is_its_turn, may_be_divided};
import package::halves::{NOT_CERTAIN, certain_halves, halves_of_row};
import package::build::{build};

@group(0) @binding(0) var owner: texture_2d_array<u32>;
@group(0) @binding(1) var item: texture_2d_array<u32>;
@group(0) @binding(2) var space: texture_2d_array<u32>;
@group(0) @binding(3) var list: texture_2d_array<u32>;
@group(0) @binding(4) var division: texture_2d_array<u32>;
@group(0) @binding(5) var bits: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(6) var tally: texture_storage_2d_array<r32uint, write>;

// References per thread.
const EACH: u32 = 16u;
const GROUPS: u32 = EACH * BLOCK / 32u;

// For each group and half, a bit for each reference.
var<workgroup> lying_in: array<atomic<u32>, 8u * GROUPS>;
// References that are not certain, in any order: what is found does not depend on it. They are few, and take long: they
// wait until they keep many threads busy.
const WAITING: u32 = 4u * BLOCK;
var<workgroup> waiting: array<u32, WAITING>;
var<workgroup> next_waiting: atomic<u32>;
var<workgroup> waiting_count: u32;

fn add_halves(k: u32, halves_found: u32) {
    var mask = halves_found;
    // At most 8 turns.
    while (mask != 0u) {
        let half = firstTrailingBit(mask);
        atomicOr(&lying_in[8u * (k / 32u) + half], 1u << (k % 32u));
        mask &= mask - 1u;
    }
}

fn cell_of_leaf(leaf: vec2u, level: u32) -> vec3u {
    let extent = space_at(space, leaf);
    return vec3u(low_of(extent.x), low_of(extent.y), low_of(extent.z)) >> vec3u(build.levels - level);
}

@compute @workgroup_size(BLOCK)
fn halve(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let begin = block_index(group, groups) * BLOCK * EACH;
    for (var k = lane; k < 8u * GROUPS; k += BLOCK) {
        atomicStore(&lying_in[k], 0u);
    }
    if (lane == 0u) {
        atomicStore(&next_waiting, 0u);
    }
    workgroupBarrier();
    for (var turn = 0u; turn < EACH; turn++) {
        let k = turn * BLOCK + lane;
        if (begin + k < launch.elements) {
            let reference = place_in(owner, begin + k);
            let leaf = place_in(list, load_at(owner, reference, 0u));
            let levels = load_at(division, leaf, 1u);
            if (is_its_turn(levels) && may_be_divided(levels, load_at(list, leaf, 1u))) {
                let level = level_of(levels);
                let mask = certain_halves(load_at(item, reference, 0u), cell_of_leaf(leaf, level), level + 1u);
                if (mask == NOT_CERTAIN) {
                    waiting[atomicAdd(&next_waiting, 1u)] = k;
                } else {
                    add_halves(k, mask);
                }
            }
        }
        workgroupBarrier();
        if (lane == 0u) {
            waiting_count = atomicLoad(&next_waiting);
        }
        let in_all = workgroupUniformLoad(&waiting_count);
        // The next turn may add one for each thread.
        if (turn + 1u < EACH && in_all + BLOCK <= WAITING) {
            continue;
        }
        for (var w = lane; w < 4u * in_all; w += BLOCK) {
            let waiter = waiting[w / 4u];
            let reference = place_in(owner, begin + waiter);
            let leaf = place_in(list, load_at(owner, reference, 0u));
            let level = level_of(load_at(division, leaf, 1u));
            add_halves(waiter, halves_of_row(load_at(item, reference, 0u), cell_of_leaf(leaf, level), level + 1u, w % 4u));
        }
        workgroupBarrier();
        if (lane == 0u) {
            atomicStore(&next_waiting, 0u);
        }
        workgroupBarrier();
    }
    for (var k = lane; k < 8u * GROUPS; k += BLOCK) {
        let its_group = begin / 32u + k / 8u;
        if (32u * its_group < launch.elements) {
            let found = atomicLoad(&lying_in[k]);
            let at = texel(its_group, textureDimensions(bits).x);
            textureStore(bits, at, k % 8u, vec4u(found));
            textureStore(tally, at, k % 8u, vec4u(countOneBits(found)));
        }
    }
}
