// A ray from its start to its nearest hit, and from there into the streams.

import package::constants::{INF};
import package::camera::{eye_ray};
import package::ray::{load_ray};
import package::tracing::{Trace, new_trace, ended_as};
import package::fused_taking::{has_counted, has_work, keep_bounds, waits_as, with_bounds};
import package::fused_waiting::{wait};
import package::fused_structure::{traced};

// Read again only by rays that wait, or are traced again.
@if(resumes || decides) alias Result = texture_storage_2d_array<r32uint, read_write>;
@else alias Result = texture_storage_2d_array<r32uint, write>;

@if(eye_rays && !decides) @group(0) @binding(2) var state: Result;
@else @group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: Result;
@if(counters) @group(0) @binding(5) var counters: Result;

// The ray's hit and counters at the end of the dispatch before.
fn resumed(start: Trace, texel: vec2u) -> Trace {
    var trace = start;
    trace.t = bitcast<f32>(textureLoad(state, texel, 1).x);
    trace.u = bitcast<f32>(textureLoad(hit, texel, 0).x);
    trace.v = bitcast<f32>(textureLoad(hit, texel, 1).x);
    trace.triangle = textureLoad(hit, texel, 2).x;
    wait.cell = textureLoad(state, texel, 2).x;
    wait.item = textureLoad(state, texel, 3).x;
    return with_bounds(trace);
}

fn trace_ray(texel: vec2u) {
    // All loads before the next branch, so that they wait for memory together.
    @if(eye_rays) let ray = eye_ray(texel);
    @else let ray = load_ray(texel);
    @if(!eye_rays || resumes || decides) if (!has_work(texel, textureLoad(state, texel, 0).x)) {
        return;
    }
    @if(any_hit && !eye_rays) let t = bitcast<f32>(textureLoad(state, texel, 1).x);
    @else let t = INF;
    var trace = new_trace(texel, ray, t);
    @if(resumes) if (wait.before) {
        trace = resumed(trace, texel);
    }
    @if(counters && (resumes || decides)) if (has_counted()) {
        trace.cells = textureLoad(counters, texel, 0).x;
        trace.tests = textureLoad(counters, texel, 1).x;
    }

    trace = traced(trace);

    textureStore(hit, texel, 0, vec4u(bitcast<u32>(trace.u)));
    textureStore(hit, texel, 1, vec4u(bitcast<u32>(trace.v)));
    textureStore(hit, texel, 2, vec4u(trace.triangle));
    var next = ended_as(trace);
    @if(resumes) if (wait.after) {
        next = waits_as(trace);
        textureStore(state, texel, 2, vec4u(wait.cell));
        textureStore(state, texel, 3, vec4u(wait.item));
        keep_bounds(trace);
    }
    textureStore(state, texel, 0, vec4u(next));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(trace.t)));
    @if(counters) {
        textureStore(counters, texel, 0, vec4u(trace.cells));
        textureStore(counters, texel, 1, vec4u(trace.tests));
        @if(!decides) textureStore(counters, texel, 2, vec4u(0u));
    }
}
