// Whether a hit counts, and by an exact order, whether it replaces the nearest one so far.

import package::bounds::{bounds};
import package::later::{later, range_of};
import package::ordered::{ordered};
import package::packed_triangles::{PackedTriangle};
import package::ray::{load_interval, load_ray, load_surface};
import package::tracing::{Trace};
import package::triangle::{Candidate, between, shear_of};

// Only between the ends of the ray, and not on the triangle that it leaves.
fn that_counts(found: Candidate, texel: vec2u, triangle: u32) -> Candidate {
    var candidate = found;
    @if(intervals) candidate = between(candidate, load_interval(texel));
    @if(leaves) candidate.is_hit = candidate.is_hit && triangle != load_surface(texel);
    @if(all_hits) {
        let ray = load_ray(texel);
        candidate = later(candidate, range_of(ray.origin, ray.direction, shear_of(ray.direction), load_surface(texel)));
    }
    return candidate;
}

@if(exact_order)
fn is_kept(
    candidate: Candidate,
    a: vec3f,
    b: vec3f,
    c: vec3f,
    triangle: u32,
    texel: vec2u,
    nearest_t: f32,
    nearest: u32,
) -> bool {
    if (!candidate.is_hit) {
        return false;
    }
    var before: Trace;
    before.t = nearest_t;
    before.error = textureLoad(bounds, texel, 0).x;
    before.open = textureLoad(bounds, texel, 1).x;
    before.triangle = nearest;
    let after = ordered(before, candidate, PackedTriangle(a, b, c, triangle));
    textureStore(bounds, texel, 0, vec4f(after.error));
    textureStore(bounds, texel, 1, vec4f(after.open));
    return after.triangle != before.triangle;
}
