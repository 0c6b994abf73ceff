import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load, load_space};

@group(0) @binding(0) var next_space: texture_2d_array<u32>;
@group(0) @binding(1) var next_list: texture_2d_array<u32>;
@group(0) @binding(2) var space: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(3) var list: texture_storage_2d_array<r32uint, write>;

// The next leaves become the leaves.
@compute @workgroup_size(BLOCK)
fn adopt_leaves(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let extent = load_space(next_space, i);
    let at = texel(i, textureDimensions(space).x);
    textureStore(space, at, 0, vec4u(extent.x));
    textureStore(space, at, 1, vec4u(extent.y));
    textureStore(space, at, 2, vec4u(extent.z));
    textureStore(list, at, 0, vec4u(load(next_list, i, 0u)));
    textureStore(list, at, 1, vec4u(load(next_list, i, 1u)));
}
