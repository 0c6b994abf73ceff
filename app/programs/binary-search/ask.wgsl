// What each element looks for, and where it may be: anywhere.

import package::launch::{BLOCK, element, launch, texel};

@group(0) @binding(0) var question: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(1) var interval: texture_storage_2d_array<r32uint, write>;

const ENTRIES: u32 = 1000u;

@compute @workgroup_size(BLOCK)
fn ask(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, launch.width);
    textureStore(question, at, 0, vec4u(250u * i));
    textureStore(interval, at, 0, vec4u(0u));
    textureStore(interval, at, 1, vec4u(ENTRIES));
}
