// Emits every photon, and forgets where those of the iteration before were stored.

import package::begins::{photon_state, photon_bounce, begin_way};
import package::constants::{DEPTH, NO_CELL, RECORD, WORKGROUP};
import package::state::{PHOTON_UNBORN, PHOTON_DONE};
import package::emission::{emitted_photon};
import package::photon_map::{photon_map};

@group(0) @binding(6) var photon_energy: texture_storage_2d_array<r32float, write>;
@group(0) @binding(8) var photon_records: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn emit_photons(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    let size = textureDimensions(photon_state);
    if (any(texel >= size)) {
        return;
    }
    let tag = textureLoad(photon_state, texel, 0).x;
    if (tag != PHOTON_UNBORN && tag != PHOTON_DONE) {
        return;
    }
    let emissions = textureLoad(photon_bounce, texel, 3).x;
    let photon = emitted_photon(emissions * photon_map.photons + texel.y * size.x + texel.x);
    for (var axis = 0u; axis < 3u; axis++) {
        textureStore(photon_energy, texel, axis, vec4f(photon.power[axis]));
        textureStore(photon_energy, texel, axis + 3u, vec4f(0.0));
        textureStore(photon_energy, texel, axis + 6u, vec4f(0.0));
    }
    for (var record = 0u; record + 1u < DEPTH; record++) {
        textureStore(photon_records, texel, record * RECORD + 9u, vec4u(NO_CELL));
    }
    textureStore(photon_bounce, texel, 2, vec4u(0u));
    textureStore(photon_bounce, texel, 3, vec4u(emissions + 1u));
    begin_way(texel, photon.origin, photon.direction, photon.power, photon.leaves, 0u, 1u);
}
