// At the hit of a ray from the camera, after its shadow ray: adds the light if nothing is in its way. A mirror or glass sends
// the ray on; on a diffuse surface, the search for the photons near it begins, or, after it, what they bring is added: first of
// the map of caustics, if there is one, then of the global one. Then the pixel is done.
//
// gathers_later: on the first diffuse surface, only caustics are looked up; a ray is sent on from there, as a path is, and its
// hit is where both maps are looked up (final gathering, Jensen 1996).

import package::at_hit::{end, go_on, light_so_far, store_radiance, pdf, vertex_of_hit};
@if(counters) import package::at_hit::{cost_of_shadow};
import package::bounced::{state, hit, bounce, carried_at, spend};
import package::connected::{INVERSE_PI};
import package::constants::{DEPTH, LIST_SIDE, NOBODY, NO_CELL, NO_TRIANGLE};
import package::state::{OCCLUDED, VISIBLE, SCATTER, GATHERED};
import package::live::{book, tiled_texel};
import package::reflected::{is_diffuse};
import package::scattered::{BY_DEPTH, BY_ESCAPE, Next, scattered};
@if(mapped) import package::searches::{CAUSTIC, GLOBAL, begin_search, first_map, irradiance};
@if(mapped) import package::searches::{is_sent_on, map_of, set_sent_on};
import package::vertex::{Vertex};

// Why a pixel's latest ray ended, besides the reasons of a path.
const BY_GATHERING: u32 = 6u;

fn done(texel: vec2u, why: u32, sum: vec3f) -> u32 {
    @if(mapped) set_sent_on(texel, 0u);
    return end(texel, why, sum);
}

fn next_ray(texel: vec2u, next: Next, triangle: u32, depth: u32) -> u32 {
    let tag = go_on(texel, next, triangle, depth);
    // A lamp that a mirror shows to a diffuse surface is in the map of caustics there: as if light had been picked for it.
    @if(mapped && gathers_later) if (is_sent_on(texel) != 0u) {
        textureStore(pdf, texel, 0, vec4f(1.0));
    }
    return tag;
}

// From the first diffuse surface.
@if(mapped && gathers_later)
fn send_on(texel: vec2u, at: Vertex, sum: vec3f) -> u32 {
    let next = scattered(at);
    if (next.ended != 0u) {
        return done(texel, next.ended, sum);
    }
    set_sent_on(texel, 1u);
    return next_ray(texel, next, at.triangle, at.depth);
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
    return done(texel, BY_GATHERING, sum);
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
    let sum = light_so_far(texel, tag);
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
        return done(texel, next.ended, sum);
    }
    return next_ray(texel, next, triangle, depth);
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn look_up(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, looked_up(tiled_texel(group, lane)));
}
