// In the place of waiting.wgsl, a ray of the kernel decide between two dispatches: it stays EXACT, and WAITS stands where the
// smallest t was that is open.

import package::constants::{INF};
import package::state::{EXACT};
import package::tracing::{Trace};

const WAITS: f32 = -1.0;

@if(resumes) @group(0) @binding(14) var bounds: texture_storage_2d_array<r32float, read_write>;

struct Wait {
    texel: vec2u,
    // Whether it waited before this dispatch, and waits after it.
    before: bool,
    after: bool,
    // As in the stream state: the cell and the item in its list, or the node and its level or item, or the triangle.
    cell: u32,
    item: u32,
}

var<private> wait: Wait;

// Whether integers have to decide what the ray hits.
fn has_work(texel: vec2u, tag: u32) -> bool {
    wait.texel = texel;
    @if(resumes) if (tag == EXACT && textureLoad(bounds, texel, 1).x == WAITS) {
        wait.before = true;
        textureStore(bounds, texel, 1, vec4f(INF));
    }
    return tag == EXACT;
}

fn wait_at(cell: u32, item: u32) {
    wait.after = true;
    wait.cell = cell;
    wait.item = item;
}

fn waits_as(trace: Trace) -> u32 {
    return EXACT;
}

fn has_waited() -> bool {
    return wait.before;
}

// A walk is counted with the one before it.
fn has_counted() -> bool {
    return true;
}

fn waiting_item() -> u32 {
    return wait.item;
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
