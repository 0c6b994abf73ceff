// Of a ray whose hits are all wanted, each of which is found after the one before it: which hits come after the last. Bounds on
// errors tell, or else integers, where they decide.

import package::constants::{INF, NO_TRIANGLE};
import package::corners::{vertex};
import package::crossing::{compare_crossings, crosses_exactly};
import package::exact::{rounds_between};
import package::packed_triangles::{PackedTriangle};
import package::tracing::{Trace};
import package::triangle::{Candidate, Shear, hit_triangle};

// Between which t the last hit lies; before all others if there was none.
@if(all_hits)
fn range_of(origin: vec3f, direction: vec3f, shear: Shear, last: u32) -> vec2f {
    if (last == NO_TRIANGLE) {
        return vec2f(-INF);
    }
    let hit = hit_triangle(origin, direction, shear, vertex(last, 0u), vertex(last, 1u), vertex(last, 2u));
    return vec2f(hit.t - hit.error, hit.t + hit.error);
}

// The candidate, which is a hit only after the last one.
@if(all_hits)
fn later(found: Candidate, range: vec2f) -> Candidate {
    var candidate = found;
    candidate.is_hit = found.is_hit && found.t + found.error >= range.x;
    candidate.is_sure = found.is_sure && found.t - found.error > range.y;
    return candidate;
}

// Whether the ray crosses the triangle, after the last hit and before its nearest one so far. Of two in one plane, the one with the
// smaller id comes first.
@if(all_hits && decides)
fn crosses_next(trace: Trace, candidate: Candidate, triangle: PackedTriangle) -> bool {
    let o = trace.origin;
    let d = trace.direction;
    if (!candidate.is_sure && !crosses_exactly(o, d, triangle.a, triangle.b, triangle.c)) {
        return false;
    }
    @if(intervals) if (!candidate.is_sure && !rounds_between(trace.interval, o, d, triangle.a, triangle.b, triangle.c)) {
        return false;
    }
    let is_surely_nearer = candidate.t + candidate.error < trace.t - trace.error;
    // What is sure comes after the last.
    var other = select(trace.leaves, NO_TRIANGLE, candidate.is_sure);
    for (var which = 0u; which < 2u; which++) {
        if (other != NO_TRIANGLE) {
            let order = compare_crossings(o, d, triangle.a, triangle.b, triangle.c, vertex(other, 0u), vertex(other, 1u), vertex(other, 2u));
            let is_before = order < 0 || (order == 0 && triangle.id < other);
            if (is_before == (which == 0u)) {
                return false;
            }
        }
        other = select(trace.triangle, NO_TRIANGLE, is_surely_nearer);
    }
    return true;
}
