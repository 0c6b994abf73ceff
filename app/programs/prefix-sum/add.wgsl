// Adds the sum of all blocks before its own to each value.

import package::launch::{BLOCK, element, launch, texel};

@group(0) @binding(0) var value: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var sum_of_block: texture_2d_array<u32>;

@compute @workgroup_size(BLOCK)
fn add(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let before = textureLoad(sum_of_block, texel(i / BLOCK, textureDimensions(sum_of_block).x), 0, 0).x;
    let at = texel(i, launch.width);
    textureStore(value, at, 0, vec4u(textureLoad(value, at, 0).x + before));
}
