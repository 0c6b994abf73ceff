// A photon that begins to walk, from a light or from a surface.

import package::constants::{INF, NO_TRIANGLE};
import package::state::{PHOTON_SETUP};

@group(0) @binding(0) var photon_origin: texture_storage_2d_array<r32float, write>;
@group(0) @binding(1) var photon_direction: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(2) var photon_state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var photon_at: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(4) var photon_surface: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(5) var photon_power: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(7) var photon_bounce: texture_storage_2d_array<r32uint, read_write>;

fn store_power(texel: vec2u, power: vec3f) {
    textureStore(photon_power, texel, 0, vec4f(power.x));
    textureStore(photon_power, texel, 1, vec4f(power.y));
    textureStore(photon_power, texel, 2, vec4f(power.z));
}

// It leaves a triangle, if any, after so many hits, which were all on mirrors and glass or not.
fn begin_way(texel: vec2u, origin: vec3f, direction: vec3f, power: vec3f, leaves: u32, hits: u32, specular: u32) -> u32 {
    for (var axis = 0u; axis < 3u; axis++) {
        textureStore(photon_origin, texel, axis, vec4f(origin[axis]));
        textureStore(photon_direction, texel, axis, vec4f(direction[axis]));
    }
    store_power(texel, power);
    textureStore(photon_surface, texel, 0, vec4u(leaves));
    textureStore(photon_bounce, texel, 0, vec4u(hits));
    textureStore(photon_bounce, texel, 1, vec4u(specular));
    textureStore(photon_at, texel, 0, vec4u(0u));
    textureStore(photon_at, texel, 1, vec4u(0u));
    textureStore(photon_at, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(photon_state, texel, 1, vec4u(bitcast<u32>(INF)));
    textureStore(photon_state, texel, 2, vec4u(0u));
    textureStore(photon_state, texel, 3, vec4u(0u));
    textureStore(photon_state, texel, 0, vec4u(PHOTON_SETUP));
    return PHOTON_SETUP;
}
