// Which of two hits a ray keeps: the one with the smallest exact t, of equal ones that of the smaller id.
//
// A bound on the error of each t tells which of two hits is nearer, unless they are closer than that; and bounds on the
// errors of a triangle's edge functions tell whether it is hit at all. If not, the ray keeps the smallest t of what it left
// open, and if its nearest hit is not before that when its walk is over, it is traced again (decide.wgsl).
//
// decides: integers tell at once.

import package::constants::{NO_TRIANGLE, TURNS_TO_CROSS, TURNS_TO_DECIDE};
import package::corners::{vertex};
import package::exact::{compare_exactly, meets_exactly, rounds_between};
import package::later::{crosses_next};
import package::packed_triangles::{PackedTriangle};
import package::tracing::{Trace, latest};
import package::triangle::{Candidate};

fn with_hit(before: Trace, candidate: Candidate, triangle: u32) -> Trace {
    var trace = before;
    trace.t = candidate.t;
    @if(exact_order) trace.error = candidate.error;
    trace.u = candidate.u;
    trace.v = candidate.v;
    trace.triangle = triangle;
    @if(whole_paths) trace.ended = trace.is_shadow;
    @else @if(any_hit) trace.ended = true;
    return trace;
}

// Keeps the nearest hit, as far as the bounds on errors tell which one it is.
@if(exact_order)
fn ordered(before: Trace, candidate: Candidate, triangle: PackedTriangle) -> Trace {
    var trace = before;
    let earliest = candidate.t - candidate.error;
    let first_of_nearest = trace.t - trace.error;
    let last = candidate.t + candidate.error;
    if (earliest > latest(trace) || triangle.id == trace.triangle) {
        return trace;
    }
    let overlaps = last >= first_of_nearest;
    @if(decides) if (!candidate.is_sure || overlaps) {
        @if(all_hits) if (crosses_next(trace, candidate, triangle)) {
            trace = with_hit(trace, candidate, triangle.id);
        }
        @else if (is_nearer_exactly(trace, candidate, triangle)) {
            trace = with_hit(trace, candidate, triangle.id);
        }
        @if(resumes && all_hits) trace.turns += TURNS_TO_CROSS;
        @else @if(resumes) trace.turns += TURNS_TO_DECIDE;
        return trace;
    }
    if (candidate.is_sure && last < latest(trace)) {
        if (overlaps) {
            trace.open = min(trace.open, first_of_nearest);
        }
        return with_hit(trace, candidate, triangle.id);
    }
    trace.open = min(trace.open, earliest);
    return trace;
}

// Whether the ray meets the triangle before its nearest hit so far, or at the same t and the triangle has the smaller id; before
// its end, if any hit ends it.
@if(decides && !all_hits)
fn is_nearer_exactly(trace: Trace, candidate: Candidate, triangle: PackedTriangle) -> bool {
    let o = trace.origin;
    let d = trace.direction;
    if (!candidate.is_sure && !meets_exactly(o, d, triangle.a, triangle.b, triangle.c)) {
        return false;
    }
    @if(intervals) if (!candidate.is_sure && !rounds_between(trace.interval, o, d, triangle.a, triangle.b, triangle.c)) {
        return false;
    }
    @if(any_hit) return candidate.t + candidate.error < trace.t
        || rounds_between(vec2f(0.0, trace.t), o, d, triangle.a, triangle.b, triangle.c);
    @else {
        let kept = trace.triangle;
        if (kept == NO_TRIANGLE || candidate.t + candidate.error < trace.t - trace.error) {
            return true;
        }
        let order = compare_exactly(o, d, triangle.a, triangle.b, triangle.c, vertex(kept, 0u), vertex(kept, 1u), vertex(kept, 2u));
        return order < 0 || (order == 0 && triangle.id < kept);
    }
}
