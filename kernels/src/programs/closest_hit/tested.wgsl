// The test of one triangle in a kernel that takes several steps.

import package::constants::{TURNS_A_TEST};
import package::later::{later};
import package::ordered::{ordered, with_hit};
import package::triangle::{hit_triangle, between, is_nearer};
import package::packed_triangles::{packed_triangle};
import package::grid::{is_in_cell};
import package::tracing::{Trace};

// Tests one triangle; cell matters only if hits must lie in it.
fn tested(before: Trace, entry: u32, cell: vec3i) -> Trace {
    var trace = before;
    let triangle = packed_triangle(entry);
    var candidate = hit_triangle(trace.origin, trace.direction, trace.shear, triangle.a, triangle.b, triangle.c);
    @if(intervals) candidate = between(candidate, trace.interval);
    @if(leaves) candidate.is_hit = candidate.is_hit && triangle.id != trace.leaves;
    @if(all_hits) candidate = later(candidate, trace.last);
    // One inside the other: a miss, as most tests end, then costs no comparison of t.
    @if(exact_order) if (candidate.is_hit) {
        trace = ordered(trace, candidate, triangle);
    }
    @else if (candidate.is_hit) {
        @if(in_cell) let accepted = candidate.t < trace.t
            && is_in_cell(trace.origin + trace.direction * candidate.t, cell);
        @else @if(robust && whole_paths) let accepted = candidate.t < trace.t
            || (!trace.is_shadow && is_nearer(candidate.t, triangle.id, trace.t, trace.triangle));
        @else @if(robust && !any_hit) let accepted = is_nearer(candidate.t, triangle.id, trace.t, trace.triangle);
        @else let accepted = candidate.t < trace.t;
        if (accepted) {
            trace = with_hit(trace, candidate, triangle.id);
        }
    }
    @if(counters) trace.tests += 1u;
    @if(resumes) trace.turns += TURNS_A_TEST;
    return trace;
}
