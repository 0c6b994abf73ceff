// Which rays the fused kernel takes: new ones, and those that wait at an item of their cell's list (ISECT_NO_HIT, ISECT_HIT)
// or between two nodes of the BVH (TRAV).

import package::state::{UNWRITTEN, TRAV_SETUP, TRAV, ISECT_NO_HIT, ISECT_HIT};
import package::tracing::{Trace, listed_as};
import package::fused_waiting::{wait, has_waited};

@if(exact_order && resumes) @group(0) @binding(14) var bounds: texture_storage_2d_array<r32float, read_write>;

// Whether the ray is new, or waits.
fn has_work(texel: vec2u, tag: u32) -> bool {
    @if(eye_rays) let is_new = tag == UNWRITTEN;
    @else let is_new = tag == TRAV_SETUP;
    @if(!resumes) return is_new;
    @else {
        wait.texel = texel;
        wait.before = tag == TRAV || tag == ISECT_NO_HIT || tag == ISECT_HIT;
        return is_new || wait.before;
    }
}

// The state of a ray that waits.
fn waits_as(trace: Trace) -> u32 {
    @if(bvh) return TRAV;
    @else return listed_as(trace);
}

// What the ray had found out about errors before it waited.
@if(resumes)
fn with_bounds(start: Trace) -> Trace {
    var trace = start;
    @if(exact_order) {
        trace.error = textureLoad(bounds, wait.texel, 0).x;
        trace.open = textureLoad(bounds, wait.texel, 1).x;
    }
    return trace;
}

@if(resumes)
fn keep_bounds(trace: Trace) {
    @if(exact_order) {
        textureStore(bounds, wait.texel, 0, vec4f(trace.error));
        textureStore(bounds, wait.texel, 1, vec4f(trace.open));
    }
}

// Whether the ray's counters begin with what they are.
fn has_counted() -> bool {
    return has_waited();
}
