// Through a binary BVH, node by node without a stack, where the other kernels of a run step through one.

import package::bvh_walk::{Visit, bvh_nodes, finite_inverse, next_node};
import package::constants::{NO_NODE};
import package::fused_waiting::{wait, wait_at, waiting_item};
import package::scene::{scene};
import package::tested::{tested};
import package::tracing::{Trace, farthest, is_spent};

@if(resumes) @group(0) @binding(6) var previous: texture_storage_2d_array<r32uint, read_write>;

fn traced(start: Trace) -> Trace {
    var trace = start;
    let inverse = finite_inverse(trace.direction);
    var at = Visit(select(0u, NO_NODE, scene.triangles == 0u), NO_NODE, false);
    @if(resumes) if (wait.before) {
        at = Visit(wait.cell, textureLoad(previous, wait.texel, 0).x, false);
    }
    while (at.node != NO_NODE) {
        @if(resumes) if (is_spent(trace)) {
            textureStore(previous, wait.texel, 0, vec4u(at.previous));
            wait_at(at.node, 0u);
            return trace;
        }
        @if(resumes) trace.turns += 1u;
        // A ray that waits at an item is already in its leaf.
        at.in_leaf = waiting_item() > 0u;
        if (!at.in_leaf) {
            at = next_node(at, trace.origin, trace.direction, inverse, farthest(trace));
            @if(counters) trace.cells += 1u;
        }
        if (at.in_leaf) {
            let node = bvh_nodes[at.node];
            let end = node.first + (node.link & 0x3fffffffu);
            for (var item = node.first + waiting_item(); item < end; item++) {
                trace = tested(trace, item, vec3i(0));
                @if(any_hit) if (trace.ended) {
                    return trace;
                }
                @if(resumes) if (is_spent(trace) && item + 1u < end) {
                    textureStore(previous, wait.texel, 0, vec4u(at.previous));
                    wait_at(at.node, item + 1u - node.first);
                    return trace;
                }
            }
        }
        @if(resumes) wait.item = 0u;
    }
    return trace;
}
