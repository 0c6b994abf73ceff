// At the hit of a path, after its shadow ray: adds the light if nothing is in its way, and sends the path on in a direction
// that the surface's BSDF decides, or ends it. What a path carries is then the product of the BSDF and the cosine, by the pdf.
//
// A path that carries little ends by chance, and one that goes on carries more in turn: Russian roulette.

import package::constants::{DEPTH, INF, LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{TRAV_SETUP, OCCLUDED, VISIBLE, SCATTER, DONE};
import package::corners::{vertex};
import package::direction::{cosine_weighted};
import package::live::{book, tiled_texel};
import package::optics::{DIFFUSE, MIRROR, optics_of, split};
import package::random::{FOR_CHANCE, FOR_DIRECTION, decided_by, next_sample};
import package::shade_surface::{material_of, surface_normal, diffuse_color};
import package::start::{start_of, leaving, through};
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

@group(0) @binding(0) var ray_origin: texture_storage_2d_array<r32float, write>;
@group(0) @binding(1) var ray_direction: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@group(0) @binding(5) var surface: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(6) var throughput: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(7) var radiance: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(8) var bounce: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(9) var primary: texture_2d_array<u32>;
@group(0) @binding(10) var pdf: texture_storage_2d_array<r32float, write>;
@group(0) @binding(11) var ended: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(12) var pending: texture_2d_array<f32>;
@if(counters) @group(0) @binding(14) var counters: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(15) var spent: texture_storage_2d_array<r32uint, read_write>;
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

// The cost of the path so far: the counters begin again with each ray.
@if(counters)
fn spend(texel: vec2u, tag: u32, is_first: bool, is_last: bool) {
    for (var layer = 0u; layer < 3u; layer++) {
        var sum = select(textureLoad(spent, texel, layer).x, 0u, is_first) + textureLoad(counters, texel, layer).x;
        @if(shadows) if (tag != SCATTER) {
            sum += textureLoad(shadow_counters, texel, layer, 0).x;
        }
        textureStore(spent, texel, layer, vec4u(sum));
        if (is_last) {
            textureStore(counters, texel, layer, vec4u(sum));
        }
    }
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
    let interpolated = surface_normal(triangle, u, v);
    let normal = select(interpolated, -interpolated, dot3(interpolated, start.normal) < 0.0);
    let chance = decided_by(texel, sample, depth, FOR_CHANCE);
    next.origin = leaving(start);
    next.throughput = carried * diffuse_color(material_of(triangle), triangle, u, v);
    var is_diffuse = true;
    @if(specular) {
        let optic = optics_of(triangle);
        is_diffuse = optic.kind == DIFFUSE;
        if (!is_diffuse) {
            var at = split(optic, direction, normal, start.is_back);
            if (dot3(at.reflected, start.normal) <= 0.0 || dot3(at.refracted, start.normal) >= 0.0) {
                at = split(optic, direction, start.normal, start.is_back);
            }
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

fn go_on(texel: vec2u, next: Next, depth: u32, triangle: u32) {
    textureStore(ray_origin, texel, 0, vec4f(next.origin.x));
    textureStore(ray_origin, texel, 1, vec4f(next.origin.y));
    textureStore(ray_origin, texel, 2, vec4f(next.origin.z));
    textureStore(ray_direction, texel, 0, vec4f(next.direction.x));
    textureStore(ray_direction, texel, 1, vec4f(next.direction.y));
    textureStore(ray_direction, texel, 2, vec4f(next.direction.z));
    textureStore(throughput, texel, 0, vec4f(next.throughput.x));
    textureStore(throughput, texel, 1, vec4f(next.throughput.y));
    textureStore(throughput, texel, 2, vec4f(next.throughput.z));
    textureStore(pdf, texel, 0, vec4f(next.pdf));
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

// The pixel has its first ray and its hit again, and its next sample begins anywhere.
fn end(texel: vec2u, why: u32, sum: vec3f) {
    textureStore(ray_origin, texel, 0, vec4f(bitcast<f32>(textureLoad(primary, texel, 0, 0).x)));
    textureStore(ray_origin, texel, 1, vec4f(bitcast<f32>(textureLoad(primary, texel, 1, 0).x)));
    textureStore(ray_origin, texel, 2, vec4f(bitcast<f32>(textureLoad(primary, texel, 2, 0).x)));
    textureStore(ray_direction, texel, 0, vec4f(bitcast<f32>(textureLoad(primary, texel, 3, 0).x)));
    textureStore(ray_direction, texel, 1, vec4f(bitcast<f32>(textureLoad(primary, texel, 4, 0).x)));
    textureStore(ray_direction, texel, 2, vec4f(bitcast<f32>(textureLoad(primary, texel, 5, 0).x)));
    textureStore(state, texel, 1, textureLoad(primary, texel, 6, 0));
    textureStore(hit, texel, 0, textureLoad(primary, texel, 7, 0));
    textureStore(hit, texel, 1, textureLoad(primary, texel, 8, 0));
    textureStore(hit, texel, 2, textureLoad(primary, texel, 9, 0));
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
    var carried = vec3f(1.0);
    if (depth > 0u) {
        carried.x = textureLoad(throughput, texel, 0).x;
        carried.y = textureLoad(throughput, texel, 1).x;
        carried.z = textureLoad(throughput, texel, 2).x;
    }
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
    @if(counters) spend(texel, tag, depth == 0u, next.ended != 0u);
    if (next.ended != 0u) {
        end(texel, next.ended, sum);
        return DONE;
    }
    go_on(texel, next, depth + 1u, triangle);
    return TRAV_SETUP;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn sample_bsdf(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, next_bounce(tiled_texel(group, lane)));
}
