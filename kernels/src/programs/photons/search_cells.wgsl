// Finds where the list of each cell begins among the sorted keys: by a binary search for the first that is not below the
// cell (Purcell et al. 2003).

import package::launch::{BLOCK, launch, element, texel};
import package::photon_map::{photon_map};

@group(0) @binding(0) var photon_key: texture_2d_array<u32>;
@group(0) @binding(1) var photon_first: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(BLOCK)
fn search_cells(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let cell = element(group, groups, lane);
    if (cell >= launch.elements) {
        return;
    }
    let width = textureDimensions(photon_key).x;
    var first = 0u;
    var left = photon_map.records;
    while (left > 0u) {
        let middle = left / 2u;
        let is_below = textureLoad(photon_key, texel(first + middle, width), 0, 0).x < cell;
        first = select(first, first + middle + 1u, is_below);
        left = select(middle, left - middle - 1u, is_below);
    }
    textureStore(photon_first, texel(cell, textureDimensions(photon_first).x), 0, vec4u(first));
}
