// A pixel's rays, one after the other: each takes the place of the one before, and at the end the first is put back.

import package::constants::{INF, NO_TRIANGLE};
import package::state::{TRAV_SETUP};

@group(0) @binding(0) var ray_origin: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(1) var ray_direction: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(5) var surface: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(6) var throughput: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(8) var bounce: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(9) var primary: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(11) var counters: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(12) var spent: texture_storage_2d_array<r32uint, read_write>;

// The share of the light along a ray that reaches the pixel.
fn carried_at(texel: vec2u, depth: u32) -> vec3f {
    if (depth == 0u) {
        return vec3f(1.0);
    }
    return vec3f(
        textureLoad(throughput, texel, 0).x,
        textureLoad(throughput, texel, 1).x,
        textureLoad(throughput, texel, 2).x,
    );
}

// A ray leaves a triangle.
fn begin_ray(texel: vec2u, origin: vec3f, direction: vec3f, carried: vec3f, triangle: u32, depth: u32) {
    textureStore(ray_origin, texel, 0, vec4f(origin.x));
    textureStore(ray_origin, texel, 1, vec4f(origin.y));
    textureStore(ray_origin, texel, 2, vec4f(origin.z));
    textureStore(ray_direction, texel, 0, vec4f(direction.x));
    textureStore(ray_direction, texel, 1, vec4f(direction.y));
    textureStore(ray_direction, texel, 2, vec4f(direction.z));
    textureStore(throughput, texel, 0, vec4f(carried.x));
    textureStore(throughput, texel, 1, vec4f(carried.y));
    textureStore(throughput, texel, 2, vec4f(carried.z));
    textureStore(surface, texel, 0, vec4u(triangle));
    textureStore(bounce, texel, 0, vec4u(depth));
    textureStore(hit, texel, 0, vec4u(0u));
    textureStore(hit, texel, 1, vec4u(0u));
    textureStore(hit, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(INF)));
    textureStore(state, texel, 2, vec4u(0u));
    textureStore(state, texel, 3, vec4u(0u));
    textureStore(state, texel, 0, vec4u(TRAV_SETUP));
}

fn put_back_primary(texel: vec2u) {
    textureStore(ray_origin, texel, 0, vec4f(bitcast<f32>(textureLoad(primary, texel, 0).x)));
    textureStore(ray_origin, texel, 1, vec4f(bitcast<f32>(textureLoad(primary, texel, 1).x)));
    textureStore(ray_origin, texel, 2, vec4f(bitcast<f32>(textureLoad(primary, texel, 2).x)));
    textureStore(ray_direction, texel, 0, vec4f(bitcast<f32>(textureLoad(primary, texel, 3).x)));
    textureStore(ray_direction, texel, 1, vec4f(bitcast<f32>(textureLoad(primary, texel, 4).x)));
    textureStore(ray_direction, texel, 2, vec4f(bitcast<f32>(textureLoad(primary, texel, 5).x)));
    textureStore(state, texel, 1, textureLoad(primary, texel, 6));
    textureStore(hit, texel, 0, textureLoad(primary, texel, 7));
    textureStore(hit, texel, 1, textureLoad(primary, texel, 8));
    textureStore(hit, texel, 2, textureLoad(primary, texel, 9));
}

// The cost of the pixel's rays so far, with that of a shadow ray: the counters begin again with each.
@if(counters)
fn spend(texel: vec2u, of_shadow: vec3u, is_first: bool, is_last: bool) {
    for (var layer = 0u; layer < 3u; layer++) {
        let before = select(textureLoad(spent, texel, layer).x, 0u, is_first);
        let sum = before + textureLoad(counters, texel, layer).x + of_shadow[layer];
        textureStore(spent, texel, layer, vec4u(sum));
        if (is_last) {
            textureStore(counters, texel, layer, vec4u(sum));
        }
    }
}
