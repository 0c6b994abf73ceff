// Adds the light of a ray's hit to the pixel's, and goes on with the rays that the surface reflects and refracts: a tree of
// rays (Whitted, 1980), depth first. The reflected ray is next, and the refracted one waits, one at each depth; where no ray
// goes on from a hit, the deepest that waits is next. Without one, the pixel is done: the first ray and its hit are put back.
//
// dielectric: a surface splits a ray in two. Mirrors alone reflect one.

import package::bounced::{
    ray_origin, ray_direction, state, hit, surface, bounce, primary, carried_at, begin_ray, put_back_primary, spend
};
import package::constants::{BRANCH, DEPTH, LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{TRAV_SETUP, SCATTER, DONE};
import package::corners::{vertex};
import package::live::{book, tiled_texel};
import package::optics::{DIFFUSE, MIRROR, Optics, optics_of, split_at};
import package::shade_surface::{material_of, surface_normal, diffuse_color};
import package::start::{start_of, on_side, leaving, through};
import package::vector::{unit3};

@group(0) @binding(4) var color: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(7) var radiance: texture_storage_2d_array<r32float, read_write>;
@if(dielectric) @group(0) @binding(10) var branches: texture_storage_2d_array<r32uint, read_write>;

// A ray that goes on from a surface.
struct Next {
    origin: vec3f,
    direction: vec3f,
    // The share of its light that reaches the pixel.
    throughput: vec3f,
    // The triangle that it leaves.
    triangle: u32,
}

// Keeps the pixel's first ray and its hit.
fn keep_primary(texel: vec2u) {
    textureStore(primary, texel, 0, vec4u(bitcast<u32>(textureLoad(ray_origin, texel, 0).x)));
    textureStore(primary, texel, 1, vec4u(bitcast<u32>(textureLoad(ray_origin, texel, 1).x)));
    textureStore(primary, texel, 2, vec4u(bitcast<u32>(textureLoad(ray_origin, texel, 2).x)));
    textureStore(primary, texel, 3, vec4u(bitcast<u32>(textureLoad(ray_direction, texel, 0).x)));
    textureStore(primary, texel, 4, vec4u(bitcast<u32>(textureLoad(ray_direction, texel, 1).x)));
    textureStore(primary, texel, 5, vec4u(bitcast<u32>(textureLoad(ray_direction, texel, 2).x)));
    textureStore(primary, texel, 6, textureLoad(state, texel, 1));
    textureStore(primary, texel, 7, textureLoad(hit, texel, 0));
    textureStore(primary, texel, 8, textureLoad(hit, texel, 1));
    textureStore(primary, texel, 9, textureLoad(hit, texel, 2));
}

// A ray that waits at a depth.
@if(dielectric)
fn branch(texel: vec2u, depth: u32) -> Next {
    let first = depth * BRANCH;
    var next: Next;
    next.origin.x = bitcast<f32>(textureLoad(branches, texel, first).x);
    next.origin.y = bitcast<f32>(textureLoad(branches, texel, first + 1u).x);
    next.origin.z = bitcast<f32>(textureLoad(branches, texel, first + 2u).x);
    next.direction.x = bitcast<f32>(textureLoad(branches, texel, first + 3u).x);
    next.direction.y = bitcast<f32>(textureLoad(branches, texel, first + 4u).x);
    next.direction.z = bitcast<f32>(textureLoad(branches, texel, first + 5u).x);
    next.throughput.x = bitcast<f32>(textureLoad(branches, texel, first + 6u).x);
    next.throughput.y = bitcast<f32>(textureLoad(branches, texel, first + 7u).x);
    next.throughput.z = bitcast<f32>(textureLoad(branches, texel, first + 8u).x);
    next.triangle = textureLoad(branches, texel, first + 9u).x;
    return next;
}

@if(dielectric)
fn wait(texel: vec2u, depth: u32, next: Next) {
    let first = depth * BRANCH;
    textureStore(branches, texel, first, vec4u(bitcast<u32>(next.origin.x)));
    textureStore(branches, texel, first + 1u, vec4u(bitcast<u32>(next.origin.y)));
    textureStore(branches, texel, first + 2u, vec4u(bitcast<u32>(next.origin.z)));
    textureStore(branches, texel, first + 3u, vec4u(bitcast<u32>(next.direction.x)));
    textureStore(branches, texel, first + 4u, vec4u(bitcast<u32>(next.direction.y)));
    textureStore(branches, texel, first + 5u, vec4u(bitcast<u32>(next.direction.z)));
    textureStore(branches, texel, first + 6u, vec4u(bitcast<u32>(next.throughput.x)));
    textureStore(branches, texel, first + 7u, vec4u(bitcast<u32>(next.throughput.y)));
    textureStore(branches, texel, first + 8u, vec4u(bitcast<u32>(next.throughput.z)));
    textureStore(branches, texel, first + 9u, vec4u(next.triangle));
}

fn go_on(texel: vec2u, next: Next, depth: u32, waiting: u32, sum: vec3f) -> u32 {
    begin_ray(texel, next.origin, next.direction, next.throughput, next.triangle, depth);
    textureStore(bounce, texel, 1, vec4u(waiting));
    textureStore(radiance, texel, 0, vec4f(sum.x));
    textureStore(radiance, texel, 1, vec4f(sum.y));
    textureStore(radiance, texel, 2, vec4f(sum.z));
    return TRAV_SETUP;
}

fn next_ray(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != SCATTER) {
        return NOBODY;
    }
    let depth = textureLoad(bounce, texel, 0).x;
    var waiting = textureLoad(bounce, texel, 1).x;
    let carried = carried_at(texel, depth);
    var sum = vec3f(textureLoad(color, texel, 0).x, textureLoad(color, texel, 1).x, textureLoad(color, texel, 2).x);
    if (depth > 0u) {
        sum *= carried;
        sum.x += textureLoad(radiance, texel, 0).x;
        sum.y += textureLoad(radiance, texel, 1).x;
        sum.z += textureLoad(radiance, texel, 2).x;
    }

    let triangle = textureLoad(hit, texel, 2).x;
    var next: Next;
    next.triangle = NO_TRIANGLE;
    var next_depth = depth + 1u;
    var optic = Optics(DIFFUSE, 1.0);
    if (triangle != NO_TRIANGLE && depth < DEPTH) {
        optic = optics_of(triangle);
    }
    if (optic.kind != DIFFUSE) {
        let u = bitcast<f32>(textureLoad(hit, texel, 0).x);
        let v = bitcast<f32>(textureLoad(hit, texel, 1).x);
        let direction = unit3(vec3f(
            textureLoad(ray_direction, texel, 0).x,
            textureLoad(ray_direction, texel, 1).x,
            textureLoad(ray_direction, texel, 2).x,
        ));
        let start = start_of(vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u), u, v, direction);
        let normal = on_side(start, surface_normal(triangle, u, v));
        let at = split_at(optic, direction, normal, start);
        let tint = carried * diffuse_color(material_of(triangle), triangle, u, v);
        let reflected = select(carried, tint, optic.kind == MIRROR) * at.reflectance;
        @if(dielectric) {
            let refracted = tint * (1.0 - at.reflectance);
            if (any(refracted != vec3f(0.0))) {
                next = Next(through(start), at.refracted, refracted, triangle);
                if (any(reflected != vec3f(0.0))) {
                    wait(texel, depth, next);
                    waiting |= 1u << depth;
                }
            }
        }
        if (any(reflected != vec3f(0.0))) {
            next = Next(leaving(start), at.reflected, reflected, triangle);
        }
        if (depth == 0u && next.triangle != NO_TRIANGLE) {
            keep_primary(texel);
        }
    }
    @if(dielectric) {
        if (next.triangle == NO_TRIANGLE && waiting != 0u) {
            let deepest = firstLeadingBit(waiting);
            next = branch(texel, deepest);
            next_depth = deepest + 1u;
            waiting ^= 1u << deepest;
        }
    }
    let is_last = next.triangle == NO_TRIANGLE;
    @if(counters) spend(texel, vec3u(0u), depth == 0u, is_last);
    if (!is_last) {
        return go_on(texel, next, next_depth, waiting, sum);
    }

    if (depth > 0u) {
        put_back_primary(texel);
        textureStore(color, texel, 0, vec4f(sum.x));
        textureStore(color, texel, 1, vec4f(sum.y));
        textureStore(color, texel, 2, vec4f(sum.z));
        textureStore(bounce, texel, 0, vec4u(0u));
    }
    // The pixel's next sample begins anywhere.
    textureStore(surface, texel, 0, vec4u(NO_TRIANGLE));
    textureStore(state, texel, 0, vec4u(DONE));
    return DONE;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn scatter(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, next_ray(tiled_texel(group, lane)));
}
