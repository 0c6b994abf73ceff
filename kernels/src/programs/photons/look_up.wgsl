// At the hit of a ray from the camera, after its shadow ray: adds the light if nothing is in its way. A mirror or glass sends
// the ray on; on a diffuse surface, the search for the photons near it begins, or, after it, what they bring is added: first of
// the map of caustics, if there is one, then of the global one. Then the pixel is done.
//
// gathers_later: on the first diffuse surface, only caustics are looked up; a ray is sent on from there, as a path is, and its
// hit is where both maps are looked up (final gathering, Jensen 1996).

import package::bounced::{
    ray_direction, state, hit, surface, bounce, carried_at, begin_ray, put_back_primary, spend,
};
import package::connected::{INVERSE_PI};
import package::constants::{DEPTH, LIST_SIDE, NOBODY, NO_CELL, NO_TRIANGLE};
import package::state::{TRAV_SETUP, OCCLUDED, VISIBLE, SCATTER, GATHERED, DONE};
import package::live::{book, tiled_texel};
import package::reflected::{is_diffuse};
import package::scattered::{BY_DEPTH, BY_ESCAPE, Next, scattered};
@if(mapped) import package::searches::{CAUSTIC, GLOBAL, begin_search, first_map, irradiance};
@if(mapped) import package::searches::{is_sent_on, map_of, set_sent_on};
@if(counters) import package::shadow_cost::{cost_of_shadow};
import package::vector::{unit3};
import package::vertex::{Vertex, vertex_at};

@group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@group(0) @binding(7) var radiance: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(10) var pdf: texture_storage_2d_array<r32float, write>;
@group(0) @binding(13) var ended: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(14) var pending: texture_2d_array<f32>;

// Why a pixel's latest ray ended, besides the reasons of a path.
const BY_GATHERING: u32 = 6u;

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
    @if(mapped) set_sent_on(texel, 0u);
    textureStore(state, texel, 0, vec4u(DONE));
    return DONE;
}

fn store_radiance(texel: vec2u, sum: vec3f) {
    textureStore(radiance, texel, 0, vec4f(sum.x));
    textureStore(radiance, texel, 1, vec4f(sum.y));
    textureStore(radiance, texel, 2, vec4f(sum.z));
}

fn go_on(texel: vec2u, next: Next, triangle: u32, depth: u32) -> u32 {
    begin_ray(texel, next.origin, next.direction, next.throughput, triangle, depth + 1u);
    textureStore(pdf, texel, 0, vec4f(next.pdf));
    // A lamp that a mirror shows to a diffuse surface is in the map of caustics there: as if light had been picked for it.
    @if(mapped && gathers_later) if (is_sent_on(texel) != 0u) {
        textureStore(pdf, texel, 0, vec4f(1.0));
    }
    return TRAV_SETUP;
}

// From the first diffuse surface.
@if(mapped && gathers_later)
fn send_on(texel: vec2u, at: Vertex, sum: vec3f) -> u32 {
    let next = scattered(at);
    if (next.ended != 0u) {
        return end(texel, next.ended, sum);
    }
    set_sent_on(texel, 1u);
    return go_on(texel, next, at.triangle, at.depth);
}

// After a search: adds what its photons bring, and looks in the other map, or sends the ray on, or ends it.
@if(mapped)
fn after_search(texel: vec2u, at: Vertex, before: vec3f) -> u32 {
    let map = map_of(texel);
    let is_sent = is_sent_on(texel);
    let sum = before + at.carried * at.color * (irradiance(texel, map, is_sent) * INVERSE_PI);
    @if(specular) if (map == CAUSTIC) {
        store_radiance(texel, sum);
        @if(gathers_later) if (is_sent == 0u && at.depth < DEPTH) {
            return send_on(texel, at, sum);
        }
        return begin_search(texel, GLOBAL, is_sent);
    }
    return end(texel, BY_GATHERING, sum);
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
        store_radiance(texel, sum);
    }
    let triangle = textureLoad(hit, texel, 2).x;
    @if(mapped) if (tag == GATHERED) {
        return after_search(texel, vertex_of_hit(texel, depth, triangle, carried), sum);
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
        let is_sent = is_sent_on(texel);
        let map = first_map(depth, is_sent);
        @if(gathers_later) if (map == NO_CELL) {
            return send_on(texel, vertex_of_hit(texel, depth, triangle, carried), sum);
        }
        return begin_search(texel, map, is_sent);
    }
    if (next.ended != 0u) {
        return end(texel, next.ended, sum);
    }
    return go_on(texel, next, triangle, depth);
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn look_up(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, looked_up(tiled_texel(group, lane)));
}
