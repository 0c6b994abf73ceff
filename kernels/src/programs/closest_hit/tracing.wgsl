// The variables of a ray in a kernel that takes several steps, kept in registers, and its test of one triangle.

@if(resumes) import package::constants::{TURNS, TURNS_A_TEST};
import package::triangle::{Shear, hit_triangle, is_nearer};
import package::packed_triangles::{packed_triangle};
@if(intervals) import package::triangle::{between};
@if(in_cell) import package::grid_walk::{is_in_cell};

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
    // Any hit was requested, and one was found.
    ended: bool,
    // Loop iterations in this dispatch so far.
    @if(resumes) turns: u32,
}

// Whether the rest is left to the next dispatch: some adapters end loops after a number of iterations, or dispatches
// after some time. Tested between two steps, never before the first, so that every dispatch makes progress.
@if(resumes)
fn is_spent(trace: Trace) -> bool {
    return trace.turns >= TURNS;
}

// Tests one triangle; cell matters only if hits must lie in it.
fn tested(before: Trace, entry: u32, cell: vec3i) -> Trace {
    var trace = before;
    let triangle = packed_triangle(entry);
    @if(intervals) let candidate = between(
        hit_triangle(trace.origin, trace.direction, trace.shear, triangle.a, triangle.b, triangle.c), trace.interval);
    @else let candidate = hit_triangle(trace.origin, trace.direction, trace.shear, triangle.a, triangle.b, triangle.c);
    // One inside the other: a miss, as most tests end, then costs no comparison of t.
    if (candidate.is_hit) {
        @if(robust && !any_hit && !in_cell) let accepted = is_nearer(candidate.t, triangle.id, trace.t, trace.triangle);
        @if(any_hit) let accepted = candidate.t < trace.t;
        @if(in_cell) let accepted = candidate.t < trace.t
            && is_in_cell(trace.origin + trace.direction * candidate.t, cell);
        @if(!robust && !in_cell) let accepted = candidate.t < trace.t;
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
