// Compares two numbers and exchanges them if they are out of order. Which two, depends only on the step.

import package::launch::{BLOCK, element, launch, texel};

@group(0) @binding(0) var number: texture_storage_2d_array<r32uint, read_write>;

@compute @workgroup_size(BLOCK)
fn exchange(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let stage = launch.parameter / 32u;
    let step = launch.parameter % 32u;
    let i = element(group, groups, lane);
    // The first step of a stage compares mirror images in a block of two runs, the others numbers at half the distance of
    // the step before.
    let partner = i ^ select(1u << (stage - step), (2u << stage) - 1u, step == 0u);
    if (partner <= i || partner >= launch.elements) {
        return;
    }
    let here = textureLoad(number, texel(i, launch.width), 0).x;
    let there = textureLoad(number, texel(partner, launch.width), 0).x;
    if (there < here) {
        textureStore(number, texel(i, launch.width), 0, vec4u(there));
        textureStore(number, texel(partner, launch.width), 0, vec4u(here));
    }
}
