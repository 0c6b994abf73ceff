// Which rays the kernel decide takes, in the place of taking.wgsl: those that are EXACT. One that waits stays so, and WAITS
// stands where the smallest t was that is open.

import package::constants::{INF};
import package::state::{EXACT};
import package::tracing::{Trace};
import package::fused_waiting::{wait};

const WAITS: f32 = -1.0;

@if(resumes) @group(0) @binding(14) var bounds: texture_storage_2d_array<r32float, read_write>;

// Whether integers have to decide what the ray hits.
fn has_work(texel: vec2u, tag: u32) -> bool {
    wait.texel = texel;
    @if(resumes) if (tag == EXACT && textureLoad(bounds, texel, 1).x == WAITS) {
        wait.before = true;
        textureStore(bounds, texel, 1, vec4f(INF));
    }
    return tag == EXACT;
}

fn waits_as(trace: Trace) -> u32 {
    return EXACT;
}

// A walk is counted with the one before it.
fn has_counted() -> bool {
    return true;
}

@if(resumes)
fn with_bounds(start: Trace) -> Trace {
    var trace = start;
    trace.error = textureLoad(bounds, wait.texel, 0).x;
    return trace;
}

@if(resumes)
fn keep_bounds(trace: Trace) {
    textureStore(bounds, wait.texel, 0, vec4f(trace.error));
    textureStore(bounds, wait.texel, 1, vec4f(WAITS));
}
