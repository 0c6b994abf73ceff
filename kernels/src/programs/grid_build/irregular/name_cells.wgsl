import package::launch::{BLOCK, launch, element_of_rows, texel};
import package::leaf::{load};

@group(0) @binding(0) var cell_of: texture_2d_array<u32>;
@group(0) @binding(1) var map_entries: texture_storage_2d_array<r32uint, read_write>;

// Makes the voxel map lead to cells, where it led to the leaves of which they were merged.
@compute @workgroup_size(BLOCK)
fn name_cells(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element_of_rows(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, textureDimensions(map_entries).x);
    let entry = textureLoad(map_entries, at, 0).x;
    if ((entry & 3u) == 0u) {
        textureStore(map_entries, at, 0, vec4u(load(cell_of, entry >> 2u, 0u) << 2u));
    }
}
