import package::launch::{BLOCK, launch, element_of_rows, texel};
import package::leaf::{load, load_space};

@group(0) @binding(0) var box: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var cell: texture_storage_2d_array<r32uint, write>;

const NO_LIST: u32 = 0xffffffffu;

// Writes the records of the cells, as rays read them: the corners of the box in 16 bits each, and where the list starts.
@compute @workgroup_size(BLOCK)
fn finish_cells(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element_of_rows(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let extent = load_space(box, i);
    let low = extent & vec3u(0xffffu);
    let high = extent >> vec3u(16u);
    let at = texel(i, textureDimensions(cell).x);
    textureStore(cell, at, 0, vec4u(low.x | (low.y << 16u)));
    textureStore(cell, at, 1, vec4u(low.z | (high.x << 16u)));
    textureStore(cell, at, 2, vec4u(high.y | (high.z << 16u)));
    textureStore(cell, at, 3, vec4u(select(load(list, i, 0u), NO_LIST, load(list, i, 1u) == 0u)));
}
