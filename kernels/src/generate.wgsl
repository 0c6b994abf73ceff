// Makes a ray for every pixel: from the eye through the pixel's centre on the view plane, which lies at
// distance 1. The direction is not normalised, so t is the depth along the view axis, and the kernel
// needs no square root, whose rounding differs from one GPU to another.

import package::constants::{INF, NO_TRIANGLE, WORKGROUP};
import package::state::{UNWRITTEN, TRAV_SETUP};

struct Camera {
    // The eye; the centre of the picture for parallel rays. Traced units.
    eye: vec3f,
    // 2 / width and 2 / height of the picture in pixels.
    pixel_x: f32,
    // From the centre of the view plane to its right edge.
    right: vec3f,
    pixel_y: f32,
    // To its upper edge.
    up: vec3f,
    // From the eye to the centre of the view plane; along all parallel rays.
    forward: vec3f,
}

@group(0) @binding(0) var ray_origin: texture_storage_2d_array<r32float, write>;
@group(0) @binding(1) var ray_direction: texture_storage_2d_array<r32float, write>;
@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, write>;
@group(1) @binding(0) var<uniform> camera: Camera;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn generate(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    if (any(texel >= textureDimensions(state))) {
        return;
    }
    if (textureLoad(state, texel, 0).x != UNWRITTEN) {
        return;
    }

    let x = (f32(texel.x) + 0.5) * camera.pixel_x - 1.0;
    let y = 1.0 - (f32(texel.y) + 0.5) * camera.pixel_y;
    @if(perspective) let origin = camera.eye;
    @if(perspective) let direction = camera.forward + camera.right * x + camera.up * y;
    @if(!perspective) let origin = camera.eye + camera.right * x + camera.up * y;
    @if(!perspective) let direction = camera.forward;

    textureStore(ray_origin, texel, 0, vec4f(origin.x));
    textureStore(ray_origin, texel, 1, vec4f(origin.y));
    textureStore(ray_origin, texel, 2, vec4f(origin.z));
    textureStore(ray_direction, texel, 0, vec4f(direction.x));
    textureStore(ray_direction, texel, 1, vec4f(direction.y));
    textureStore(ray_direction, texel, 2, vec4f(direction.z));
    textureStore(hit, texel, 0, vec4u(0u));
    textureStore(hit, texel, 1, vec4u(0u));
    textureStore(hit, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(state, texel, 0, vec4u(TRAV_SETUP));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(INF)));
    textureStore(state, texel, 2, vec4u(0u));
    textureStore(state, texel, 3, vec4u(0u));
}
