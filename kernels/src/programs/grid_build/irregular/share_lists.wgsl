// Finds which references the neighbour before their leaf lists, too; counts them in groups of 32.

import package::launch::{BLOCK, launch, block_index, texel};
import package::leaf::{load};
import package::in_list::{item, is_listed};

@group(0) @binding(0) var owner: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var neighbor: texture_2d_array<u32>;
@group(0) @binding(3) var bits: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var tally: texture_storage_2d_array<r32uint, write>;

const NOBODY: u32 = 0xffffffffu;
const GROUPS: u32 = BLOCK / 32u;

// For each group, a bit for each reference.
var<workgroup> known: array<atomic<u32>, GROUPS>;

@compute @workgroup_size(BLOCK)
fn share_lists(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    let i = block * BLOCK + lane;
    if (lane < GROUPS) {
        atomicStore(&known[lane], 0u);
    }
    workgroupBarrier();
    if (i < launch.elements) {
        let before = load(neighbor, load(owner, i, 0u), 1u);
        if (before != NOBODY && is_listed(load(list, before, 0u), load(list, before, 1u), load(item, i, 0u))) {
            atomicOr(&known[lane / 32u], 1u << (lane % 32u));
        }
    }
    workgroupBarrier();
    let its_group = block * GROUPS + lane;
    if (lane < GROUPS && 32u * its_group < launch.elements) {
        let found = atomicLoad(&known[lane]);
        let at = texel(its_group, textureDimensions(bits).x);
        textureStore(bits, at, 0, vec4u(found));
        textureStore(tally, at, 0, vec4u(countOneBits(found)));
    }
}
