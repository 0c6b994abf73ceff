// The cell of each place where a photon is stored, as the key that it is sorted by: all ones without a photon, so that these
// are last.

import package::constants::{NO_CELL, RECORD};
import package::launch::{BLOCK, launch, element, texel};
import package::photon_map::{photon_map, cell_of, index_of, place_of};

@group(0) @binding(0) var photon_records: texture_2d_array<u32>;
@group(0) @binding(1) var photon_key: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(BLOCK)
fn key_photons(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i % photon_map.photons, textureDimensions(photon_records).x);
    let first = i / photon_map.photons * RECORD;
    var cell = NO_CELL;
    let map = textureLoad(photon_records, at, first + 9u, 0).x;
    if (map != NO_CELL) {
        let point = vec3f(
            bitcast<f32>(textureLoad(photon_records, at, first, 0).x),
            bitcast<f32>(textureLoad(photon_records, at, first + 1u, 0).x),
            bitcast<f32>(textureLoad(photon_records, at, first + 2u, 0).x),
        );
        cell = index_of(min(map, photon_map.maps - 1u), cell_of(place_of(point)));
    }
    let to = texel(i, textureDimensions(photon_key).x);
    textureStore(photon_key, to, 0, vec4u(cell));
    textureStore(photon_key, to, 1, vec4u(i));
}
