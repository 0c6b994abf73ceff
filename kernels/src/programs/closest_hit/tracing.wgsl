// The variables of a ray in a kernel that takes several steps, kept in registers.

import package::constants::{INF, NO_TRIANGLE, TURNS};
import package::state::{ISECT_NO_HIT, ISECT_HIT, EXACT, SHADE, BACKGROUND};
import package::camera::{Ray};
import package::triangle::{Shear, shear_of};
import package::later::{range_of};
import package::ray::{load_interval, load_surface};

// The ray, its nearest hit so far, and counters.
struct Trace {
    origin: vec3f,
    direction: vec3f,
    shear: Shear,
    // Hits count between these t.
    @if(intervals) interval: vec2f,
    t: f32,
    // exact_order: a bound on the error of t, and the smallest t at which there may be another hit, which only integers can
    // tell.
    error: f32,
    open: f32,
    u: f32,
    v: f32,
    triangle: u32,
    cells: u32,
    tests: u32,
    // The triangle that the ray leaves.
    @if(leaves) leaves: u32,
    // all_hits: of the hit on that triangle.
    @if(all_hits) last: vec2f,
    // It ends at any hit, in a kernel that traces others too.
    @if(whole_paths) is_shadow: bool,
    // Any hit was requested, and one was found.
    ended: bool,
    // Loop iterations in this dispatch so far.
    @if(resumes) turns: u32,
}

// No hit so far; hits at t or beyond do not count.
fn new_trace(texel: vec2u, ray: Ray, t: f32) -> Trace {
    var trace = trace_from(ray, load_surface(texel), t);
    @if(intervals) trace.interval = load_interval(texel);
    return trace;
}

// The same, of a ray that leaves a triangle.
fn trace_from(ray: Ray, leaves: u32, t: f32) -> Trace {
    var trace: Trace;
    trace.origin = ray.origin;
    trace.direction = ray.direction;
    trace.shear = shear_of(ray.direction);
    @if(leaves) trace.leaves = leaves;
    @if(all_hits) trace.last = range_of(ray.origin, ray.direction, trace.shear, leaves);
    trace.t = t;
    trace.open = INF;
    trace.triangle = NO_TRIANGLE;
    return trace;
}

// The state of a ray whose walk is over.
fn ended_as(trace: Trace) -> u32 {
    @if(exact_order && !decides) if (is_open(trace)) {
        return EXACT;
    }
    return select(SHADE, BACKGROUND, trace.triangle == NO_TRIANGLE);
}

// The state of a ray in a list.
fn listed_as(trace: Trace) -> u32 {
    @if(any_hit) return ISECT_NO_HIT;
    @else return select(ISECT_HIT, ISECT_NO_HIT, trace.triangle == NO_TRIANGLE);
}

// The largest t that the nearest hit may have.
fn latest(trace: Trace) -> f32 {
    @if(exact_order) return trace.t + trace.error;
    @else return trace.t;
}

// Whether only integers can tell what is hit.
fn is_open(trace: Trace) -> bool {
    return !trace.ended && trace.open <= latest(trace) && trace.open < INF;
}

// No box or cell behind this t has a hit that is wanted.
fn farthest(trace: Trace) -> f32 {
    @if(intervals) return min(latest(trace), trace.interval.y);
    @else return latest(trace);
}

// Whether the rest is left to the next dispatch: some adapters end loops after a number of iterations, or dispatches
// after some time. Tested between two steps, never before the first, so that every dispatch makes progress.
fn is_spent(trace: Trace) -> bool {
    return trace.turns >= TURNS;
}
