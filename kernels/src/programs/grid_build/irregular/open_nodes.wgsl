import package::launch::{BLOCK, launch, element_of_rows, texel};
import package::leaf::{load_space};
import package::leaf_level::{opened_by};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var opened: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(2) var cell_of: texture_storage_2d_array<r32uint, write>;

// Counts the nodes of the octrees, each at its first leaf; gives every leaf its number.
@compute @workgroup_size(BLOCK)
fn open_nodes(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element_of_rows(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    textureStore(opened, texel(i, textureDimensions(opened).x), 0, vec4u(opened_by(load_space(space, i))));
    textureStore(cell_of, texel(i, textureDimensions(cell_of).x), 0, vec4u(i));
}
