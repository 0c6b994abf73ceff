// Emits every photon, and forgets where those of the iteration before were stored.

import package::constants::{DEPTH, INF, NO_CELL, NO_TRIANGLE, RECORD, WORKGROUP};
import package::state::{PHOTON_UNBORN, PHOTON_SETUP, PHOTON_DONE};
import package::emission::{emitted_photon};
import package::photon_map::{photon_map};

@group(0) @binding(0) var photon_origin: texture_storage_2d_array<r32float, write>;
@group(0) @binding(1) var photon_direction: texture_storage_2d_array<r32float, write>;
@group(0) @binding(2) var photon_state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var photon_at: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var photon_surface: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(5) var photon_power: texture_storage_2d_array<r32float, write>;
@group(0) @binding(6) var photon_energy: texture_storage_2d_array<r32float, write>;
@group(0) @binding(7) var photon_bounce: texture_storage_2d_array<r32uint, read_write>;
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
        textureStore(photon_origin, texel, axis, vec4f(photon.origin[axis]));
        textureStore(photon_direction, texel, axis, vec4f(photon.direction[axis]));
        textureStore(photon_power, texel, axis, vec4f(photon.power[axis]));
        textureStore(photon_energy, texel, axis, vec4f(photon.power[axis]));
        textureStore(photon_energy, texel, axis + 3u, vec4f(0.0));
        textureStore(photon_energy, texel, axis + 6u, vec4f(0.0));
    }
    for (var record = 0u; record + 1u < DEPTH; record++) {
        textureStore(photon_records, texel, record * RECORD + 9u, vec4u(NO_CELL));
    }
    textureStore(photon_surface, texel, 0, vec4u(photon.leaves));
    textureStore(photon_bounce, texel, 0, vec4u(0u));
    textureStore(photon_bounce, texel, 1, vec4u(1u));
    textureStore(photon_bounce, texel, 2, vec4u(0u));
    textureStore(photon_bounce, texel, 3, vec4u(emissions + 1u));
    textureStore(photon_at, texel, 0, vec4u(0u));
    textureStore(photon_at, texel, 1, vec4u(0u));
    textureStore(photon_at, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(photon_state, texel, 1, vec4u(bitcast<u32>(INF)));
    textureStore(photon_state, texel, 2, vec4u(0u));
    textureStore(photon_state, texel, 3, vec4u(0u));
    textureStore(photon_state, texel, 0, vec4u(PHOTON_SETUP));
}
