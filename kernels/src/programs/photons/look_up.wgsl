// At the hit of a ray from the camera, after its shadow ray: adds the light if nothing is in its way. A mirror or glass sends
// the ray on; on a diffuse surface, the search for the photons near it begins, or, after it, what they bring is added, and
// the pixel is done.

import package::bounced::{
    ray_direction, state, hit, surface, bounce, carried_at, begin_ray, put_back_primary, spend,
};
import package::connected::{INVERSE_PI};
import package::constants::{DEPTH, LIST_SIDE, NOBODY, NO_CELL, NO_TRIANGLE};
import package::state::{TRAV_SETUP, OCCLUDED, VISIBLE, SCATTER, GATHER, GATHERED, DONE};
import package::live::{book, tiled_texel};
import package::photon_map::{photon_map};
import package::reflected::{is_diffuse};
import package::scattered::{BY_DEPTH, BY_ESCAPE, Next, scattered};
import package::vector::{unit3};
import package::vertex::{Vertex, vertex_at};

@group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@group(0) @binding(7) var radiance: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(10) var pdf: texture_storage_2d_array<r32float, write>;
@group(0) @binding(13) var ended: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(14) var pending: texture_2d_array<f32>;
@if(counters && shadows) @group(0) @binding(16) var shadow_counters: texture_2d_array<u32>;
@if(mapped) @group(0) @binding(17) var gathering: texture_storage_2d_array<r32uint, read_write>;
@if(mapped) @group(0) @binding(18) var gathered: texture_storage_2d_array<r32float, read_write>;

// Why a pixel's latest ray ended, besides the reasons of a path.
const BY_GATHERING: u32 = 6u;

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

@if(mapped)
fn begin_search(texel: vec2u) {
    textureStore(gathering, texel, 0, vec4u(NO_CELL));
    for (var layer = 1u; layer < 5u; layer++) {
        textureStore(gathering, texel, layer, vec4u(0u));
    }
    textureStore(gathered, texel, 0, vec4f(-1.0));
    textureStore(gathered, texel, 1, vec4f(photon_map.radius * photon_map.radius));
    for (var layer = 2u; layer < 11u; layer++) {
        textureStore(gathered, texel, layer, vec4f(0.0));
    }
}

// The flux by area that photons bring: each counts less the farther away it is, nothing at the edge of the circle in which
// they were found. A cone (Jensen 1996), whose mean over the circle is 1/3.
@if(mapped)
fn irradiance(texel: vec2u) -> vec3f {
    let power = vec3f(
        textureLoad(gathered, texel, 5).x,
        textureLoad(gathered, texel, 6).x,
        textureLoad(gathered, texel, 7).x,
    );
    let weighted = vec3f(
        textureLoad(gathered, texel, 8).x,
        textureLoad(gathered, texel, 9).x,
        textureLoad(gathered, texel, 10).x,
    );
    // With fewer photons than wanted, there are no others within the radius.
    let whole = photon_map.radius * photon_map.radius;
    let has_enough = textureLoad(gathering, texel, 3).x >= photon_map.nearest;
    let squared = max(select(whole, textureLoad(gathered, texel, 4).x, has_enough), whole * 1e-6);
    return max(power - weighted * (1.0 / sqrt(squared)), vec3f(0.0)) * (3.0 * INVERSE_PI / squared);
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

fn looked_up(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let tag = textureLoad(state, texel, 0).x;
    if (tag != SCATTER && tag != OCCLUDED && tag != VISIBLE && tag != GATHERED) {
        return NOBODY;
    }
    let depth = textureLoad(bounce, texel, 0).x;
    let carried = carried_at(texel, depth);
    var sum = vec3f(
        textureLoad(radiance, texel, 0).x,
        textureLoad(radiance, texel, 1).x,
        textureLoad(radiance, texel, 2).x,
    );
    @if(shadows) if (tag == VISIBLE) {
        sum.x += textureLoad(pending, texel, 0, 0).x;
        sum.y += textureLoad(pending, texel, 1, 0).x;
        sum.z += textureLoad(pending, texel, 2, 0).x;
        textureStore(radiance, texel, 0, vec4f(sum.x));
        textureStore(radiance, texel, 1, vec4f(sum.y));
        textureStore(radiance, texel, 2, vec4f(sum.z));
    }
    let triangle = textureLoad(hit, texel, 2).x;
    @if(mapped) if (tag == GATHERED) {
        let at = vertex_of_hit(texel, depth, triangle, carried);
        sum += at.carried * at.color * (irradiance(texel) * INVERSE_PI);
        return end(texel, BY_GATHERING, sum);
    }
    var next: Next;
    next.ended = BY_ESCAPE;
    if (triangle != NO_TRIANGLE) {
        next.ended = BY_GATHERING;
        if (!is_diffuse(triangle)) {
            next.ended = BY_DEPTH;
            if (depth < DEPTH) {
                next = scattered(vertex_of_hit(texel, depth, triangle, carried));
            }
        }
    }
    @if(counters) spend(texel, cost_of_shadow(texel, tag), depth == 0u, next.ended != 0u);
    @if(mapped) if (next.ended == BY_GATHERING) {
        begin_search(texel);
        textureStore(state, texel, 0, vec4u(GATHER));
        return GATHER;
    }
    if (next.ended != 0u) {
        return end(texel, next.ended, sum);
    }
    begin_ray(texel, next.origin, next.direction, next.throughput, triangle, depth + 1u);
    textureStore(pdf, texel, 0, vec4f(next.pdf));
    return TRAV_SETUP;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn look_up(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, looked_up(tiled_texel(group, lane)));
}
