// Generates a ray for every pixel.

import package::constants::{INF, NO_TRIANGLE, WORKGROUP};
import package::state::{UNWRITTEN, TRAV_SETUP};
import package::camera::{eye_ray, eye_ray_at};
import package::samples::{jitter, sampling};

@group(0) @binding(0) var ray_origin: texture_storage_2d_array<r32float, write>;
@group(0) @binding(1) var ray_direction: texture_storage_2d_array<r32float, write>;
@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, write>;
@if(samples) @group(0) @binding(5) var accumulated: texture_2d_array<f32>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn generate(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    if (any(texel >= textureDimensions(state))) {
        return;
    }
    if (textureLoad(state, texel, 0).x != UNWRITTEN) {
        return;
    }

    // The next sample's index grows by the number of samples so far.
    @if(samples) let sample = sampling.first + u32(textureLoad(accumulated, texel, 4, 0).x);
    @if(samples) let place = jitter(texel, sample);
    @if(samples) let ray = eye_ray_at(vec2f(texel) + place);
    @else let ray = eye_ray(texel);
    textureStore(ray_origin, texel, 0, vec4f(ray.origin.x));
    textureStore(ray_origin, texel, 1, vec4f(ray.origin.y));
    textureStore(ray_origin, texel, 2, vec4f(ray.origin.z));
    textureStore(ray_direction, texel, 0, vec4f(ray.direction.x));
    textureStore(ray_direction, texel, 1, vec4f(ray.direction.y));
    textureStore(ray_direction, texel, 2, vec4f(ray.direction.z));
    textureStore(hit, texel, 0, vec4u(0u));
    textureStore(hit, texel, 1, vec4u(0u));
    textureStore(hit, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(state, texel, 0, vec4u(TRAV_SETUP));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(INF)));
    textureStore(state, texel, 2, vec4u(0u));
    textureStore(state, texel, 3, vec4u(0u));
}
