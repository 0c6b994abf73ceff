// The variables of a ray in a kernel that takes several steps, kept in registers, and its test of one triangle.

import package::constants::{NO_TRIANGLE, TURNS, TURNS_A_TEST};
import package::state::{ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::camera::{Ray};
import package::triangle::{Shear, shear_of, hit_triangle, between, is_nearer};
import package::packed_triangles::{packed_triangle};
import package::ray::{load_interval, load_surface};
import package::grid::{is_in_cell};

// The ray, its nearest hit so far, and counters.
struct Trace {
    origin: vec3f,
    direction: vec3f,
    shear: Shear,
    // Hits count between these t.
    @if(intervals) interval: vec2f,
    t: f32,
    u: f32,
    v: f32,
    triangle: u32,
    cells: u32,
    tests: u32,
    // The triangle that the ray leaves.
    @if(leaves) leaves: u32,
    // Any hit was requested, and one was found.
    ended: bool,
    // Loop iterations in this dispatch so far.
    @if(resumes) turns: u32,
}

// No hit so far; hits at t or beyond do not count.
fn new_trace(texel: vec2u, ray: Ray, t: f32) -> Trace {
    var trace: Trace;
    trace.origin = ray.origin;
    trace.direction = ray.direction;
    trace.shear = shear_of(ray.direction);
    @if(intervals) trace.interval = load_interval(texel);
    @if(leaves) trace.leaves = load_surface(texel);
    trace.t = t;
    trace.triangle = NO_TRIANGLE;
    return trace;
}

// The state of a ray whose walk is over.
fn ended_as(trace: Trace) -> u32 {
    return select(SHADE, BACKGROUND, trace.triangle == NO_TRIANGLE);
}

// The state of a ray in a list.
fn listed_as(trace: Trace) -> u32 {
    @if(any_hit) return ISECT_NO_HIT;
    @else return select(ISECT_HIT, ISECT_NO_HIT, trace.triangle == NO_TRIANGLE);
}

// No box or cell behind this t has a hit that is wanted.
fn farthest(trace: Trace) -> f32 {
    @if(intervals) return min(trace.t, trace.interval.y);
    @else return trace.t;
}

// Whether the rest is left to the next dispatch: some adapters end loops after a number of iterations, or dispatches
// after some time. Tested between two steps, never before the first, so that every dispatch makes progress.
fn is_spent(trace: Trace) -> bool {
    return trace.turns >= TURNS;
}

// Tests one triangle; cell matters only if hits must lie in it.
fn tested(before: Trace, entry: u32, cell: vec3i) -> Trace {
    var trace = before;
    let triangle = packed_triangle(entry);
    var candidate = hit_triangle(trace.origin, trace.direction, trace.shear, triangle.a, triangle.b, triangle.c);
    @if(intervals) candidate = between(candidate, trace.interval);
    @if(leaves) candidate.is_hit = candidate.is_hit && triangle.id != trace.leaves;
    // One inside the other: a miss, as most tests end, then costs no comparison of t.
    if (candidate.is_hit) {
        @if(in_cell) let accepted = candidate.t < trace.t
            && is_in_cell(trace.origin + trace.direction * candidate.t, cell);
        @else @if(robust && !any_hit) let accepted = is_nearer(candidate.t, triangle.id, trace.t, trace.triangle);
        @else let accepted = candidate.t < trace.t;
        if (accepted) {
            trace.t = candidate.t;
            trace.u = candidate.u;
            trace.v = candidate.v;
            trace.triangle = triangle.id;
            @if(any_hit) trace.ended = true;
        }
    }
    @if(counters) trace.tests += 1u;
    @if(resumes) trace.turns += TURNS_A_TEST;
    return trace;
}
