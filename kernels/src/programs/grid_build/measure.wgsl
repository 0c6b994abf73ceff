// The length of each cell's list; a scan turns the lengths into starts.

import package::launch::{BLOCK, launch, element, texel};

@group(0) @binding(0) var begin: texture_2d_array<u32>;
@group(0) @binding(1) var end: texture_2d_array<u32>;
@group(0) @binding(2) var start: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(BLOCK)
fn measure(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, textureDimensions(start).x);
    let length = textureLoad(end, at, 0, 0).x - textureLoad(begin, at, 0, 0).x;
    textureStore(start, at, 0, vec4u(length));
}
