// A pixel's ray at its hit, after the shadow ray that was cast there: what that brought and cost, and how the ray goes on, or
// the pixel ends.

import package::bounced::{ray_direction, state, hit, surface, bounce, begin_ray, put_back_primary};
import package::constants::{NO_TRIANGLE};
import package::scattered::{Next};
import package::state::{TRAV_SETUP, SCATTER, VISIBLE, DONE};
import package::vector::{unit3};
import package::vertex::{Vertex, vertex_at};

@group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@group(0) @binding(7) var radiance: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(10) var pdf: texture_storage_2d_array<r32float, write>;
@group(0) @binding(13) var ended: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(14) var pending: texture_2d_array<f32>;
@if(counters && shadows) @group(0) @binding(16) var shadow_counters: texture_2d_array<u32>;

fn vertex_of_hit(texel: vec2u, depth: u32, triangle: u32, carried: vec3f) -> Vertex {
    let u = bitcast<f32>(textureLoad(hit, texel, 0).x);
    let v = bitcast<f32>(textureLoad(hit, texel, 1).x);
    let direction = unit3(vec3f(
        textureLoad(ray_direction, texel, 0).x,
        textureLoad(ray_direction, texel, 1).x,
        textureLoad(ray_direction, texel, 2).x,
    ));
    return vertex_at(texel, depth, triangle, u, v, direction, carried);
}

fn store_radiance(texel: vec2u, sum: vec3f) {
    textureStore(radiance, texel, 0, vec4f(sum.x));
    textureStore(radiance, texel, 1, vec4f(sum.y));
    textureStore(radiance, texel, 2, vec4f(sum.z));
}

// The pixel's light so far, with what the shadow ray brought if nothing was in its way.
fn light_so_far(texel: vec2u, tag: u32) -> vec3f {
    var sum = vec3f(
        textureLoad(radiance, texel, 0).x,
        textureLoad(radiance, texel, 1).x,
        textureLoad(radiance, texel, 2).x,
    );
    @if(shadows) if (tag == VISIBLE) {
        sum.x += textureLoad(pending, texel, 0, 0).x;
        sum.y += textureLoad(pending, texel, 1, 0).x;
        sum.z += textureLoad(pending, texel, 2, 0).x;
        store_radiance(texel, sum);
    }
    return sum;
}

// The cost of the shadow ray, if one was cast.
@if(counters)
fn cost_of_shadow(texel: vec2u, tag: u32) -> vec3u {
    @if(shadows) if (tag != SCATTER) {
        return vec3u(
            textureLoad(shadow_counters, texel, 0, 0).x,
            textureLoad(shadow_counters, texel, 1, 0).x,
            textureLoad(shadow_counters, texel, 2, 0).x,
        );
    }
    return vec3u(0u);
}

fn go_on(texel: vec2u, next: Next, triangle: u32, depth: u32) -> u32 {
    begin_ray(texel, next.origin, next.direction, next.throughput, triangle, depth + 1u);
    textureStore(pdf, texel, 0, vec4f(next.pdf));
    return TRAV_SETUP;
}

// The pixel has its first ray and its hit again, and its next sample begins anywhere.
fn end(texel: vec2u, why: u32, sum: vec3f) -> u32 {
    put_back_primary(texel);
    textureStore(color, texel, 0, vec4f(sum.x));
    textureStore(color, texel, 1, vec4f(sum.y));
    textureStore(color, texel, 2, vec4f(sum.z));
    textureStore(ended, texel, 0, vec4u(why));
    textureStore(bounce, texel, 0, vec4u(0u));
    textureStore(pdf, texel, 0, vec4f(0.0));
    textureStore(surface, texel, 0, vec4u(NO_TRIANGLE));
    textureStore(state, texel, 0, vec4u(DONE));
    return DONE;
}
