// A solution of exercise 3, the triangle test.
//
// This is the kernel intersect. It tests a ray against one triangle of its cell's list.

import package::constants::{INF, LIST_SIDE, NOBODY};
import package::corners::{vertex};
import package::intersect_structure::{after_list, entry_of, has_item, list_of};
import package::live::{listed_texel, send};
import package::ray::{load_ray};
import package::state::{ISECT_HIT, ISECT_NO_HIT};
import package::triangle::{is_nearer};
import package::vector::{cross3, dot3};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;

struct Candidate {
    // The point is origin + t * direction.
    t: f32,
    // The weights of corners b and c: the point is (1 - u - v) * a + u * b + v * c.
    u: f32,
    v: f32,
    is_hit: bool,
}

// Where the ray meets the triangle with corners a, b and c, and whether it does. Both sides of a triangle can be hit.
fn hit_triangle(origin: vec3f, direction: vec3f, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    // Möller and Trumbore (1997): Cramer's rule for origin - a = u (b - a) + v (c - a) - t direction.
    let edge1 = b - a;
    let edge2 = c - a;
    let p = cross3(direction, edge2);
    let det = dot3(edge1, p);
    let s = origin - a;
    let q = cross3(s, edge1);
    let u = dot3(s, p) / det;
    let v = dot3(direction, q) / det;
    let t = dot3(edge2, q) / det;
    return Candidate(t, u, v, det != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < INF);
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
    // What happens at the end of the list is exercise 4.
    if (ended) {
        tag = after_list(texel, tag, nearest_t);
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
