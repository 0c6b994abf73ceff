// At the hit of a path, after its shadow ray: adds the light if nothing is in its way, and sends the path on in a direction
// that the surface's BSDF decides, or ends it. What a path carries is then the product of the BSDF and the cosine, by the pdf.
//
// A path that carries little ends by chance, and one that goes on carries more in turn: Russian roulette.

import package::bounced::{ray_direction, state, hit, surface, bounce, carried_at, begin_ray, put_back_primary, spend};
import package::constants::{DEPTH, LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{TRAV_SETUP, OCCLUDED, VISIBLE, SCATTER, DONE};
import package::corners::{vertex};
import package::direction::{cosine_weighted};
import package::live::{book, tiled_texel};
import package::optics::{DIFFUSE, MIRROR, optics_of, split_at};
import package::random::{FOR_CHANCE, FOR_DIRECTION, decided_by, next_sample};
import package::shade_surface::{material_of, surface_normal, diffuse_color};
import package::start::{start_of, on_side, leaving, through};
import package::vector::{dot3, largest3, unit3};

const INVERSE_PI: f32 = 0.318309886;
// Bounces before a path may end by chance, and the largest chance to go on.
const ROULETTE_DEPTH: u32 = 3u;
const MOST_CHANCE: f32 = 0.95;

// Why a path ended.
const BY_ESCAPE: u32 = 1u;
const BY_DEPTH: u32 = 2u;
const BY_ABSORPTION: u32 = 3u;
const BY_SURFACE: u32 = 4u;
const BY_ROULETTE: u32 = 5u;

@group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@group(0) @binding(7) var radiance: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(10) var pdf: texture_storage_2d_array<r32float, write>;
@group(0) @binding(13) var ended: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(14) var pending: texture_2d_array<f32>;
@if(counters && shadows) @group(0) @binding(16) var shadow_counters: texture_2d_array<u32>;

// Where a path goes on.
struct Next {
    origin: vec3f,
    direction: vec3f,
    // What it carries.
    throughput: vec3f,
    // The pdf of the direction, by solid angle; 0 if there was no other.
    pdf: f32,
    // Why it ends instead, or 0.
    ended: u32,
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

fn scattered(texel: vec2u, depth: u32, triangle: u32, carried: vec3f) -> Next {
    var next: Next;
    let sample = next_sample(texel);
    let u = bitcast<f32>(textureLoad(hit, texel, 0).x);
    let v = bitcast<f32>(textureLoad(hit, texel, 1).x);
    let direction = unit3(vec3f(
        textureLoad(ray_direction, texel, 0).x,
        textureLoad(ray_direction, texel, 1).x,
        textureLoad(ray_direction, texel, 2).x,
    ));
    let start = start_of(vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u), u, v, direction);
    let normal = on_side(start, surface_normal(triangle, u, v));
    let chance = decided_by(texel, sample, depth, FOR_CHANCE);
    next.origin = leaving(start);
    next.throughput = carried * diffuse_color(material_of(triangle), triangle, u, v);
    var is_diffuse = true;
    @if(specular) {
        let optic = optics_of(triangle);
        is_diffuse = optic.kind == DIFFUSE;
        if (!is_diffuse) {
            let at = split_at(optic, direction, normal, start);
            next.direction = at.reflected;
            if (optic.kind != MIRROR) {
                if (chance.x < at.reflectance) {
                    next.throughput = carried;
                } else {
                    next.origin = through(start);
                    next.direction = at.refracted;
                }
            }
        }
    }
    if (is_diffuse) {
        next.direction = cosine_weighted(normal, decided_by(texel, sample, depth, FOR_DIRECTION));
        next.pdf = dot3(normal, next.direction) * INVERSE_PI;
        if (next.pdf <= 0.0 || dot3(start.normal, next.direction) <= 0.0) {
            next.ended = BY_SURFACE;
        }
    }
    let most = largest3(next.throughput);
    if (!(most > 0.0)) {
        next.ended = BY_ABSORPTION;
    } else if (depth >= ROULETTE_DEPTH) {
        let goes_on = min(most, MOST_CHANCE);
        next.throughput *= 1.0 / goes_on;
        if (chance.y >= goes_on && next.ended == 0u) {
            next.ended = BY_ROULETTE;
        }
    }
    return next;
}

// The pixel has its first ray and its hit again, and its next sample begins anywhere.
fn end(texel: vec2u, why: u32, sum: vec3f) {
    put_back_primary(texel);
    textureStore(color, texel, 0, vec4f(sum.x));
    textureStore(color, texel, 1, vec4f(sum.y));
    textureStore(color, texel, 2, vec4f(sum.z));
    textureStore(ended, texel, 0, vec4u(why));
    textureStore(bounce, texel, 0, vec4u(0u));
    textureStore(pdf, texel, 0, vec4f(0.0));
    textureStore(surface, texel, 0, vec4u(NO_TRIANGLE));
    textureStore(state, texel, 0, vec4u(DONE));
}

fn next_bounce(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let tag = textureLoad(state, texel, 0).x;
    if (tag != SCATTER && tag != OCCLUDED && tag != VISIBLE) {
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
    var next: Next;
    next.ended = select(BY_DEPTH, BY_ESCAPE, triangle == NO_TRIANGLE);
    if (triangle != NO_TRIANGLE && depth < DEPTH) {
        next = scattered(texel, depth, triangle, carried);
    }
    @if(counters) spend(texel, cost_of_shadow(texel, tag), depth == 0u, next.ended != 0u);
    if (next.ended != 0u) {
        end(texel, next.ended, sum);
        return DONE;
    }
    begin_ray(texel, next.origin, next.direction, next.throughput, triangle, depth + 1u);
    textureStore(pdf, texel, 0, vec4f(next.pdf));
    return TRAV_SETUP;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn sample_bsdf(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, next_bounce(tiled_texel(group, lane)));
}
