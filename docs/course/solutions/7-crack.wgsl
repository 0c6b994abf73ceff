// A solution of exercise 7, a crack and its repair.
//
// This is the kernel intersect. It tests a ray against one triangle of its cell's list.

import package::camera::{Ray};
import package::constants::{INF, LIST_SIDE, NOBODY};
import package::corners::{vertex};
import package::intersect_structure::{after_list, entry_of, has_item, list_of};
import package::live::{listed_texel, send};
import package::ray::{load_ray};
import package::state::{ISECT_HIT, ISECT_NO_HIT};
import package::triangle::{across, is_nearer, shear_of, with_largest_last};
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

// How a ray, seen along its direction, passes the three edges of a triangle.
struct Weights {
    // For each corner: positive if the ray passes the opposite edge on one side, negative on the other, 0 through the edge.
    // By their sum they are the weights of the corners.
    a: f32,
    b: f32,
    c: f32,
    is_inside: bool,
}

// a, b, c: the corners, measured from the ray's origin.
// p, q, r: the same corners as the ray sees them: projected along its direction onto a plane, where the ray is at (0, 0).
fn weights_of(direction: vec3f, a: vec3f, b: vec3f, c: vec3f, p: vec2f, q: vec2f, r: vec2f) -> Weights {
    // Each weight from the two corners of its edge, and from nothing else: the neighbour at that edge computes the same two
    // products, in exchanged places. They are compared, not subtracted: a compiler may contract a difference of products, and
    // then it is not the negative of the neighbour's.
    let left = q.x * r.y >= q.y * r.x && r.x * p.y >= r.y * p.x && p.x * q.y >= p.y * q.x;
    let right = q.x * r.y <= q.y * r.x && r.x * p.y <= r.y * p.x && p.x * q.y <= p.y * q.x;
    return Weights(q.x * r.y - q.y * r.x, r.x * p.y - r.y * p.x, p.x * q.y - p.y * q.x, left || right);
}

// Where the ray meets the triangle with corners a, b and c, and whether it does.
fn hit_triangle(ray: Ray, a: vec3f, b: vec3f, c: vec3f) -> Candidate {
    let shear = shear_of(ray.direction);
    let to_a = a - ray.origin;
    let to_b = b - ray.origin;
    let to_c = c - ray.origin;
    // x, y and z in another order: the ray's direction is longest along the last.
    let last_a = with_largest_last(to_a, shear.axis);
    let last_b = with_largest_last(to_b, shear.axis);
    let last_c = with_largest_last(to_c, shear.axis);
    let p = across(last_a, shear);
    let q = across(last_b, shear);
    let r = across(last_c, shear);
    let weights = weights_of(ray.direction, to_a, to_b, to_c, p, q, r);
    let sum = weights.a + weights.b + weights.c;
    let w = weights.a / sum;
    let u = weights.b / sum;
    let v = weights.c / sum;
    let t = (w * last_a.z + u * last_b.z + v * last_c.z) * shear.z;
    return Candidate(t, u, v, weights.is_inside && sum != 0.0 && t > 0.0 && t < INF);
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
            ray,
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
