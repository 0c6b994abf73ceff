// Exercise 4: the list's end. Write list_ended; 4-list-end.md says what it decides.
//
// This is the kernel intersect. It tests a ray against one triangle of its cell's list.

import package::constants::{LIST_SIDE, NOBODY};
import package::corners::{vertex};
import package::intersect_structure::{entry_of, has_item, list_of};
import package::live::{listed_texel, send};
import package::ray::{load_ray};
import package::state::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
import package::triangle::{hit_triangle, is_nearer, shear_of};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(4) var tmax: texture_2d_array<f32>;

// The state in which a ray goes on after the last triangle of its cell's list: TRAV, and traverse_grid takes it to the next
// cell; SHADE, and the nearest hit is final; or BACKGROUND, and it hits nothing.
//
// tag: ISECT_HIT if the ray has hit a triangle, in this cell's list or in that of an earlier cell, else ISECT_NO_HIT.
// nearest_t: the t of the nearest hit so far; INF without one.
// tmax: for each axis, the t at which the ray crosses the next plane of the grid.
fn list_ended(tag: u32, nearest_t: f32, tmax: vec3f) -> u32 {
    // HOLE: every ray ends in its first cell.
    return select(BACKGROUND, SHADE, tag == ISECT_HIT);
}

// Returns the state in which the ray goes on.
fn step_item(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    var tag = textureLoad(state, texel, 0).x;
    if (tag != ISECT_NO_HIT && tag != ISECT_HIT) {
        return NOBODY;
    }
    var nearest_t = bitcast<f32>(textureLoad(state, texel, 1).x);
    var item = textureLoad(state, texel, 3).x;
    let list = list_of(textureLoad(state, texel, 2).x);
    var ended = true;
    if (has_item(list, item)) {
        let entry = entry_of(list, item);
        ended = entry.is_last;
        let ray = load_ray(texel);
        let candidate = hit_triangle(
            ray.origin,
            ray.direction,
            shear_of(ray.direction),
            vertex(entry.triangle, 0u),
            vertex(entry.triangle, 1u),
            vertex(entry.triangle, 2u),
        );
        if (candidate.is_hit && is_nearer(candidate.t, entry.triangle, nearest_t, textureLoad(hit, texel, 2).x)) {
            textureStore(hit, texel, 0, vec4u(bitcast<u32>(candidate.u)));
            textureStore(hit, texel, 1, vec4u(bitcast<u32>(candidate.v)));
            textureStore(hit, texel, 2, vec4u(entry.triangle));
            nearest_t = candidate.t;
            tag = ISECT_HIT;
        }
        item += 1u;
    }
    if (ended) {
        let exits = vec3f(
            textureLoad(tmax, texel, 0, 0).x,
            textureLoad(tmax, texel, 1, 0).x,
            textureLoad(tmax, texel, 2, 0).x,
        );
        tag = list_ended(tag, nearest_t, exits);
    }
    textureStore(state, texel, 1, vec4u(bitcast<u32>(nearest_t)));
    textureStore(state, texel, 3, vec4u(item));
    textureStore(state, texel, 0, vec4u(tag));
    return tag;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn intersect(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let texel = listed_texel(group, lane);
    send(lane, texel, step_item(texel));
}
