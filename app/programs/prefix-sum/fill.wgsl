// The numbers to add up.

import package::launch::{BLOCK, element, launch, texel};

@group(0) @binding(0) var value: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(BLOCK)
fn fill(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i < launch.elements) {
        textureStore(value, texel(i, launch.width), 0, vec4u(i % 3u));
    }
}
