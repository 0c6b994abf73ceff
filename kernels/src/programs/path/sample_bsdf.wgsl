// At the hit of a path, after its shadow ray: adds the light if nothing is in its way, and sends the path on, or ends it.

import package::bounced::{
    ray_direction, state, hit, surface, bounce, carried_at, begin_ray, put_back_primary, spend,
};
import package::constants::{DEPTH, LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{TRAV_SETUP, OCCLUDED, VISIBLE, SCATTER, DONE};
import package::live::{book, tiled_texel};
import package::scattered::{BY_DEPTH, BY_ESCAPE, Next, scattered};
@if(counters) import package::shadow_cost::{cost_of_shadow};
import package::vector::{unit3};
import package::vertex::{vertex_at};

@group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@group(0) @binding(7) var radiance: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(10) var pdf: texture_storage_2d_array<r32float, write>;
@group(0) @binding(13) var ended: texture_storage_2d_array<r32uint, write>;
@if(shadows) @group(0) @binding(14) var pending: texture_2d_array<f32>;

fn scattered_at_hit(texel: vec2u, depth: u32, triangle: u32, carried: vec3f) -> Next {
    let u = bitcast<f32>(textureLoad(hit, texel, 0).x);
    let v = bitcast<f32>(textureLoad(hit, texel, 1).x);
    let direction = unit3(vec3f(
        textureLoad(ray_direction, texel, 0).x,
        textureLoad(ray_direction, texel, 1).x,
        textureLoad(ray_direction, texel, 2).x,
    ));
    return scattered(vertex_at(texel, depth, triangle, u, v, direction, carried));
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
        next = scattered_at_hit(texel, depth, triangle, carried);
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
