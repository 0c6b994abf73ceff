// At the hit of a ray from the camera, after its shadow ray: adds the light if nothing is in its way. A mirror or glass sends
// the ray on; on a diffuse surface, the search for the photons near it begins, or, after it, what they bring is added: first of
// the map of caustics, if there is one, then of the global one. Then the pixel is done.
//
// gathers_later: on the first diffuse surface, only caustics are looked up; a ray is sent on from there, as a path is, and its
// hit is where both maps are looked up (final gathering, Jensen 1996).
//
// samples: with every iteration, the radius of each pixel shrinks (progressive photon mapping, Hachisuka and Jensen 2009). Of
// the photons found, it keeps a share, as if they had been found in the smaller circle: so their number grows, and the circle
// still shrinks to nothing. Their estimate, by sums that shrink as well, is the mean of those of the iterations.

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
@if(mapped && samples) @group(0) @binding(19) var shrunk: texture_storage_2d_array<r32float, read_write>;

// The maps.
const GLOBAL: u32 = 0u;
const CAUSTIC: u32 = 1u;
// Of the photons found in an iteration, the share that counts in the next.
const KEPT: f32 = 0.6666667;

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

// The squared radius of a search in a map that earlier iterations have left, or 0. Places that are seen directly and by way of
// a diffuse surface have their own.
@if(mapped)
fn radius_before(texel: vec2u, map: u32, is_sent: u32) -> f32 {
    @if(samples) return textureLoad(shrunk, texel, 4u * is_sent + 2u * map + 1u).x;
    @else return 0.0;
}

@if(mapped)
fn begin_search(texel: vec2u, map: u32, is_sent: u32) {
    let before = radius_before(texel, map, is_sent);
    let whole = photon_map.radius * photon_map.radius;
    // With a radius of its own, all photons within it count, in one search.
    let has_radius = before > 0.0;
    let limit = select(whole, before, has_radius);
    textureStore(gathering, texel, 0, vec4u(NO_CELL));
    textureStore(gathering, texel, 1, vec4u(0u));
    textureStore(gathering, texel, 2, vec4u(0u));
    textureStore(gathering, texel, 3, vec4u(0u));
    textureStore(gathering, texel, 4, vec4u(select(0u, 1u, has_radius)));
    textureStore(gathering, texel, 5, vec4u(map));
    textureStore(gathering, texel, 6, vec4u(is_sent));
    textureStore(gathering, texel, 7, vec4u(0u));
    for (var layer = 0u; layer < 10u; layer++) {
        textureStore(gathered, texel, layer, vec4f(select(0.0, limit, layer == 0u || layer == 2u)));
    }
}

// The map to look in first, or none, if the ray is sent on at once.
@if(mapped)
fn first_map(depth: u32, is_sent: u32) -> u32 {
    @if(specular) return CAUSTIC;
    @else @if(gathers_later) return select(GLOBAL, NO_CELL, is_sent == 0u && depth < DEPTH);
    @else return GLOBAL;
}

// The flux by area that photons bring: each counts less the farther away it is, nothing at the edge of the circle in which
// they were found. A cone (Jensen 1996), whose mean over the circle is 1/3.
@if(mapped)
fn irradiance(texel: vec2u, map: u32, is_sent: u32) -> vec3f {
    let power = vec3f(
        textureLoad(gathered, texel, 4).x,
        textureLoad(gathered, texel, 5).x,
        textureLoad(gathered, texel, 6).x,
    );
    let weighted = vec3f(
        textureLoad(gathered, texel, 7).x,
        textureLoad(gathered, texel, 8).x,
        textureLoad(gathered, texel, 9).x,
    );
    // With fewer photons than wanted, there are no others within the radius.
    let whole = photon_map.radius * photon_map.radius;
    let before = radius_before(texel, map, is_sent);
    let found = textureLoad(gathering, texel, 3).x;
    let of_search = select(whole, textureLoad(gathered, texel, 3).x, found >= photon_map.nearest);
    let squared = max(select(of_search, before, before > 0.0), whole * 1e-6);
    @if(samples) {
        let slot = 4u * is_sent + 2u * map;
        let enough = textureLoad(shrunk, texel, slot).x;
        let kept = enough + KEPT * f32(found);
        let all = enough + f32(found);
        textureStore(shrunk, texel, slot, vec4f(kept));
        textureStore(shrunk, texel, slot + 1u, vec4f(select(squared, squared * (kept / all), found > 0u)));
    }
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
    @if(mapped) textureStore(gathering, texel, 6, vec4u(0u));
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
    return TRAV_SETUP;
}

// From the first diffuse surface.
@if(mapped && gathers_later)
fn send_on(texel: vec2u, at: Vertex, sum: vec3f) -> u32 {
    let next = scattered(at);
    if (next.ended != 0u) {
        return end(texel, next.ended, sum);
    }
    textureStore(gathering, texel, 6, vec4u(1u));
    return go_on(texel, next, at.triangle, at.depth);
}

@if(mapped)
fn search(texel: vec2u, map: u32, is_sent: u32) -> u32 {
    begin_search(texel, map, is_sent);
    textureStore(state, texel, 0, vec4u(GATHER));
    return GATHER;
}

// After a search: adds what its photons bring, and looks in the other map, or sends the ray on, or ends it.
@if(mapped)
fn after_search(texel: vec2u, at: Vertex, before: vec3f) -> u32 {
    let map = textureLoad(gathering, texel, 5).x;
    let is_sent = textureLoad(gathering, texel, 6).x;
    let sum = before + at.carried * at.color * (irradiance(texel, map, is_sent) * INVERSE_PI);
    @if(specular) if (map == CAUSTIC) {
        store_radiance(texel, sum);
        @if(gathers_later) if (is_sent == 0u && at.depth < DEPTH) {
            return send_on(texel, at, sum);
        }
        return search(texel, GLOBAL, is_sent);
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
        let is_sent = textureLoad(gathering, texel, 6).x;
        let map = first_map(depth, is_sent);
        @if(gathers_later) if (map == NO_CELL) {
            return send_on(texel, vertex_of_hit(texel, depth, triangle, carried), sum);
        }
        return search(texel, map, is_sent);
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
