// Compares the keys of two elements and exchanges them if they are out of order: a step of a bitonic sort.

import package::launch::{BLOCK, launch, element, texel};

@group(0) @binding(0) var key: texture_storage_2d_array<r32uint, read_write>;

// A key, and the element that it came from: equal keys keep their order.
fn load(i: u32, width: u32) -> vec2u {
    let at = texel(i, width);
    return vec2u(textureLoad(key, at, 0).x, textureLoad(key, at, 1).x);
}

fn store(i: u32, width: u32, value: vec2u) {
    let at = texel(i, width);
    textureStore(key, at, 0, vec4u(value.x));
    textureStore(key, at, 1, vec4u(value.y));
}

@compute @workgroup_size(BLOCK)
fn exchange(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    // Stage s merges runs of 2^s elements. Its first step compares each element with its mirror image in the block of two
    // runs, the others with the element at half the distance of the step before. So all steps put the smaller key first, and
    // a partner beyond the end stands for a key that is larger than all.
    let stage = launch.parameter / 32u;
    let step = launch.parameter % 32u;
    let i = element(group, groups, lane);
    let partner = i ^ select(1u << (stage - step), (2u << stage) - 1u, step == 0u);
    if (partner <= i || partner >= launch.elements) {
        return;
    }
    let width = textureDimensions(key).x;
    let here = load(i, width);
    let there = load(partner, width);
    if (there.x < here.x || (there.x == here.x && there.y < here.y)) {
        store(i, width, there);
        store(partner, width, here);
    }
}
