// Finds where the sorted references to each cell begin and end. Cells without references keep 0 and 0.

import package::launch::{BLOCK, launch, element, texel};

@group(0) @binding(0) var cell_in: texture_2d_array<u32>;
@group(0) @binding(1) var begin: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(2) var end: texture_storage_2d_array<r32uint, write>;

fn load_cell(i: u32) -> u32 {
    return textureLoad(cell_in, texel(i, textureDimensions(cell_in).x), 0, 0).x;
}

@compute @workgroup_size(BLOCK)
fn mark(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let cell = load_cell(i);
    let at = texel(cell, textureDimensions(begin).x);
    var is_first = true;
    if (i > 0u) {
        is_first = load_cell(i - 1u) != cell;
    }
    var is_last = true;
    if (i + 1u < launch.elements) {
        is_last = load_cell(i + 1u) != cell;
    }
    if (is_first) {
        textureStore(begin, at, 0, vec4u(i));
    }
    if (is_last) {
        textureStore(end, at, 0, vec4u(i + 1u));
    }
}
