// Follows a path from its first ray to its end: what the other kernels do one step at a time, with the path in registers.
// A turn of the loop traces a ray to its nearest hit, or a shadow ray to any. The loop has one exit, at its end: software
// Vulkan (Mesa 22.3) counted the last walk of some rays twice with others.

import package::camera::{Ray};
import package::connected::{connected, emitted};
import package::constants::{DEPTH, INF, NO_TRIANGLE, WORKGROUP};
import package::fused_structure::{traced};
import package::ray::{load_ray};
import package::scattered::{BY_DEPTH, BY_ESCAPE, Next, scattered};
import package::scene::{scene};
import package::shade_light::{shading};
import package::state::{TRAV_SETUP, DONE};
import package::tracing::{Trace, trace_from};
import package::vector::{unit3};
import package::vertex::{vertex_at};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var color: texture_storage_2d_array<r32float, write>;
@group(0) @binding(5) var ended: texture_storage_2d_array<r32uint, write>;
@if(counters) @group(0) @binding(6) var counters: texture_storage_2d_array<r32uint, write>;

// The hit of the pixel's first ray.
fn store_hit(texel: vec2u, trace: Trace) {
    textureStore(hit, texel, 0, vec4u(bitcast<u32>(trace.u)));
    textureStore(hit, texel, 1, vec4u(bitcast<u32>(trace.v)));
    textureStore(hit, texel, 2, vec4u(trace.triangle));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(trace.t)));
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn fused_path(@builtin(global_invocation_id) id: vec3u) {
    let texel = vec2u(id.x, id.y + WORKGROUP * scene.first_row);
    if (any(texel >= scene.size)) {
        return;
    }
    let ray = load_ray(texel);
    if (textureLoad(state, texel, 0).x != TRAV_SETUP) {
        return;
    }
    var trace = trace_from(ray, NO_TRIANGLE, INF);
    var next: Next;
    var carried = vec3f(1.0);
    var sum = vec3f(0.0);
    var depth = 0u;
    // The triangle that the ray leaves.
    var leaves = NO_TRIANGLE;
    // The pdf of the ray's direction, and what its shadow ray may bring.
    var pdf = 0.0;
    @if(shadows) var pending = vec3f(0.0);
    @if(counters) var spent = vec2u(0u);
    var is_over = false;
    while (!is_over) {
        trace = traced(trace);
        @if(counters) spent += vec2u(trace.cells, trace.tests);
        var casts = false;
        if (trace.is_shadow) {
            @if(shadows) if (trace.triangle == NO_TRIANGLE) {
                sum += pending;
            }
        } else {
            if (depth == 0u) {
                store_hit(texel, trace);
            }
            leaves = trace.triangle;
            if (leaves == NO_TRIANGLE) {
                sum += carried * shading.background;
                next.ended = BY_ESCAPE;
            } else {
                let at = vertex_at(texel, depth, leaves, trace.u, trace.v, unit3(trace.direction), carried);
                @if(emissive) sum += emitted(at, trace.origin, pdf);
                if (depth == DEPTH) {
                    next.ended = BY_DEPTH;
                } else {
                    next = scattered(at);
                    @if(shadows) {
                        let to = connected(at);
                        casts = to.is_cast;
                        if (casts) {
                            pending = to.arrives;
                            trace = trace_from(Ray(to.origin, to.direction), leaves, to.end);
                            trace.is_shadow = true;
                        }
                    }
                }
            }
        }
        is_over = !casts && next.ended != 0u;
        if (!casts && !is_over) {
            carried = next.throughput;
            pdf = next.pdf;
            depth += 1u;
            trace = trace_from(Ray(next.origin, next.direction), leaves, INF);
        }
    }
    textureStore(color, texel, 0, vec4f(sum.x));
    textureStore(color, texel, 1, vec4f(sum.y));
    textureStore(color, texel, 2, vec4f(sum.z));
    textureStore(ended, texel, 0, vec4u(next.ended));
    textureStore(state, texel, 0, vec4u(DONE));
    @if(counters) {
        textureStore(counters, texel, 0, vec4u(spent.x));
        textureStore(counters, texel, 1, vec4u(spent.y));
        textureStore(counters, texel, 2, vec4u(0u));
    }
}
