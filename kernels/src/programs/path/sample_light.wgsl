// At the hit of a path: adds the light that the surface emits, and casts a shadow ray to a light or to a point of a triangle
// that glows, picked at random, with what arrives if nothing is in its way. Without a hit, the path has left the scene, and
// sees the background, which is around it at any distance.

import package::connected::{Connection, connected, emitted};
import package::constants::{LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{SHADE, BACKGROUND, SHADOW_SETUP, SCATTER};
import package::live::{book, tiled_texel};
import package::ray::{load_origin, load_direction};
import package::shade_light::{shading};
import package::vector::{unit3};
import package::vertex::{vertex_at};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_2d_array<u32>;
@group(0) @binding(4) var bounce: texture_2d_array<u32>;
@group(0) @binding(5) var throughput: texture_2d_array<f32>;
@group(0) @binding(6) var radiance: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(7) var primary: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(8) var light: texture_storage_2d_array<r32uint, write>;
@if(emissive) @group(0) @binding(9) var pdf: texture_2d_array<f32>;
@if(shadows) @group(0) @binding(10) var pending: texture_storage_2d_array<r32float, write>;
@if(shadows) @group(0) @binding(11) var blocker: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(12) var surface: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(13) var shadow_origin: texture_storage_2d_array<r32float, write>;
@if(shadows) @group(0) @binding(14) var shadow_direction: texture_storage_2d_array<r32float, write>;

// The pixel's first ray and its hit: those of the last path are put back when it ends.
fn keep_primary(texel: vec2u) {
    let origin = bitcast<vec3u>(load_origin(texel));
    let direction = bitcast<vec3u>(load_direction(texel));
    textureStore(primary, texel, 0, vec4u(origin.x));
    textureStore(primary, texel, 1, vec4u(origin.y));
    textureStore(primary, texel, 2, vec4u(origin.z));
    textureStore(primary, texel, 3, vec4u(direction.x));
    textureStore(primary, texel, 4, vec4u(direction.y));
    textureStore(primary, texel, 5, vec4u(direction.z));
    textureStore(primary, texel, 6, textureLoad(state, texel, 1));
    textureStore(primary, texel, 7, textureLoad(hit, texel, 0, 0));
    textureStore(primary, texel, 8, textureLoad(hit, texel, 1, 0));
    textureStore(primary, texel, 9, textureLoad(hit, texel, 2, 0));
}

@if(shadows)
fn cast_shadow(texel: vec2u, ray: Connection) {
    textureStore(shadow_origin, texel, 0, vec4f(ray.origin.x));
    textureStore(shadow_origin, texel, 1, vec4f(ray.origin.y));
    textureStore(shadow_origin, texel, 2, vec4f(ray.origin.z));
    textureStore(shadow_direction, texel, 0, vec4f(ray.direction.x));
    textureStore(shadow_direction, texel, 1, vec4f(ray.direction.y));
    textureStore(shadow_direction, texel, 2, vec4f(ray.direction.z));
    textureStore(pending, texel, 0, vec4f(ray.arrives.x));
    textureStore(pending, texel, 1, vec4f(ray.arrives.y));
    textureStore(pending, texel, 2, vec4f(ray.arrives.z));
    textureStore(surface, texel, 0, textureLoad(hit, texel, 2, 0));
    textureStore(blocker, texel, 2, vec4u(NO_TRIANGLE));
    textureStore(light, texel, 0, vec4u(ray.id));
    textureStore(light, texel, 1, textureLoad(state, texel, 1));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(ray.end)));
    textureStore(state, texel, 0, vec4u(SHADOW_SETUP));
}

fn at_hit(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let tag = textureLoad(state, texel, 0).x;
    if (tag != SHADE && tag != BACKGROUND) {
        return NOBODY;
    }
    let depth = textureLoad(bounce, texel, 0, 0).x;
    var carried = vec3f(1.0);
    var sum = vec3f(0.0);
    if (depth == 0u) {
        keep_primary(texel);
    } else {
        carried.x = textureLoad(throughput, texel, 0, 0).x;
        carried.y = textureLoad(throughput, texel, 1, 0).x;
        carried.z = textureLoad(throughput, texel, 2, 0).x;
        sum.x = textureLoad(radiance, texel, 0).x;
        sum.y = textureLoad(radiance, texel, 1).x;
        sum.z = textureLoad(radiance, texel, 2).x;
    }
    let triangle = textureLoad(hit, texel, 2, 0).x;
    var is_sent = false;
    if (tag == BACKGROUND) {
        sum += carried * shading.background;
    } else {
        let u = bitcast<f32>(textureLoad(hit, texel, 0, 0).x);
        let v = bitcast<f32>(textureLoad(hit, texel, 1, 0).x);
        let at = vertex_at(texel, depth, triangle, u, v, unit3(load_direction(texel)), carried);
        @if(emissive) sum += emitted(at, load_origin(texel), textureLoad(pdf, texel, 0, 0).x);
        @if(shadows) {
            let ray = connected(at);
            is_sent = ray.is_cast;
            if (is_sent) {
                cast_shadow(texel, ray);
            }
        }
    }
    textureStore(radiance, texel, 0, vec4f(sum.x));
    textureStore(radiance, texel, 1, vec4f(sum.y));
    textureStore(radiance, texel, 2, vec4f(sum.z));
    if (is_sent) {
        return SHADOW_SETUP;
    }
    textureStore(state, texel, 0, vec4u(SCATTER));
    return SCATTER;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn sample_light(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, at_hit(tiled_texel(group, lane)));
}
