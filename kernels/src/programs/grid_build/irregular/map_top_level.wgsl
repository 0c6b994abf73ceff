import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};
import package::map_entry::{entry_of};

@group(0) @binding(0) var tree_top: texture_2d_array<u32>;
@group(0) @binding(1) var map_top: texture_storage_2d_array<r32uint, write>;

// Writes the entries of the voxel map for the cells of the top level.
@compute @workgroup_size(BLOCK)
fn map_top_level(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    textureStore(map_top, texel(i, textureDimensions(map_top).x), 0, vec4u(entry_of(load(tree_top, i, 0u))));
}
