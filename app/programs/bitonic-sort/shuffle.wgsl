// Random numbers below 1000, the same in every run: the hash pcg (Jarzynski and Olano 2020).

import package::launch::{BLOCK, element, launch, texel};

@group(0) @binding(0) var number: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(BLOCK)
fn shuffle(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let state = i * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    textureStore(number, texel(i, launch.width), 0, vec4u(((word >> 22u) ^ word) % 1000u));
}
