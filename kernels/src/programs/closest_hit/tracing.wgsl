// What a kernel that takes several steps keeps in registers of a ray, and its test of one triangle.

@if(resumes) import package::constants::{TURNS, TURNS_A_TEST};
import package::triangle::{Shear, hit_triangle, is_nearer};
import package::packed_triangles::{packed_triangle};
@if(in_cell) import package::grid_walk::{is_in_cell};

// The ray, what it has hit so far, and what that took.
struct Trace {
    origin: vec3f,
    direction: vec3f,
    shear: Shear,
    t: f32,
    u: f32,
    v: f32,
    triangle: u32,
    cells: u32,
    tests: u32,
    // Any hit was asked for and found.
    ended: bool,
    // Loop turns of this dispatch so far.
    @if(resumes) turns: u32,
}

// Whether the rest is left to the next dispatch: some adapters end loops after so many turns, or a dispatch after so
// long. Asked between two steps, never before the first, so that every dispatch gets on.
@if(resumes)
fn is_spent(trace: Trace) -> bool {
    return trace.turns >= TURNS;
}

// Tests one triangle; the cell is used where hits must lie in it.
fn tested(before: Trace, entry: u32, cell: vec3i) -> Trace {
    var trace = before;
    let triangle = packed_triangle(entry);
    let candidate = hit_triangle(trace.origin, trace.direction, trace.shear, triangle.a, triangle.b, triangle.c);
    @if(robust && !any_hit && !in_cell) let accepted = is_nearer(candidate.t, triangle.id, trace.t, trace.triangle);
    @if(any_hit) let accepted = candidate.t < trace.t;
    @if(in_cell) let accepted = candidate.t < trace.t
        && is_in_cell(trace.origin + trace.direction * candidate.t, cell);
    @if(!robust && !in_cell) let accepted = candidate.t < trace.t;
    if (candidate.is_hit && accepted) {
        trace.t = candidate.t;
        trace.u = candidate.u;
        trace.v = candidate.v;
        trace.triangle = triangle.id;
        @if(any_hit) trace.ended = true;
    }
    @if(counters) trace.tests += 1u;
    @if(resumes) trace.turns += TURNS_A_TEST;
    return trace;
}
