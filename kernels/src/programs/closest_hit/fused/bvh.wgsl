// Through an eight-wide BVH, node by node, with a stack of siblings that wait.
//
// resumes: a ray that waits keeps no stack but a restart trail (Laine, 2010): for each level's group, 4 bits with the
// child that was entered last, or NO_CHILD. A group's level is in bits 8-15 of its word.

import package::constants::{WIDE_STACK};
import package::scene::{scene};
import package::bvh_walk::{finite_inverse};
import package::wide_walk::{
    TRAIL_WORDS, MOST_LEVELS, NO_CHILD, trail_child, with_trail_child,
    WideGroup, wide_ray, visit_wide, wide_child, wide_entry,
};
import package::tested::{tested};
import package::tracing::{Trace, farthest, is_spent};
import package::fused_waiting::{wait, wait_at};

@if(resumes) @group(0) @binding(6) var trail: texture_storage_2d_array<r32uint, read_write>;

fn traced(start: Trace) -> Trace {
    var trace = start;
    if (scene.triangles == 0u) {
        return trace;
    }
    let ray = wide_ray(trace.origin, finite_inverse(trace.direction));
    // Only as large as this scene's BVH needs: it is filled with zeros first, for every ray.
    var stack: array<vec2u, WIDE_STACK>;
    var height = 0u;
    // The root as the only hit of a group; its slot is chosen by the octant, so that no inner child precedes it.
    var group = WideGroup(0u, 0x80000000u);
    @if(resumes) var path: array<u32, TRAIL_WORDS>;
    @if(resumes) if (wait.before) {
        for (var word = 0u; word < TRAIL_WORDS; word++) {
            path[word] = textureLoad(trail, wait.texel, word).x;
        }
        // Down to where the ray waits: later siblings whose boxes are met wait on the stack again.
        for (var level = 0u; level < wait.item; level++) {
            let child = trail_child(path[level / 8u], level);
            let node = wide_child(group, 24u + child, ray);
            group.bits &= (1u << (24u + child)) - 1u;
            if (group.bits > 0x00ffffffu) {
                stack[height] = vec2u(group.base, group.bits);
                height += 1u;
            }
            group = visit_wide(node, ray, farthest(trace)).inner;
            group.bits |= (level + 1u) << 8u;
        }
        let child = trail_child(path[wait.item / 8u], wait.item);
        if (child != NO_CHILD) {
            group.bits &= (1u << (24u + child)) - 1u;
        }
        trace.turns += wait.item;
        // The nodes ahead may be behind the nearest hit by now.
        if (group.bits <= 0x00ffffffu) {
            if (height == 0u) {
                return trace;
            }
            height -= 1u;
            group = WideGroup(stack[height].x, stack[height].y);
        }
    }
    loop {
        let bit = firstLeadingBit(group.bits);
        let node = wide_child(group, bit, ray);
        group.bits &= ~(1u << bit);
        @if(resumes) let level = (group.bits >> 8u) & 0xffu;
        @if(resumes) path[level / 8u] = with_trail_child(path[level / 8u], level, bit - 24u);
        @if(resumes) trace.turns += 1u;
        if (group.bits > 0x00ffffffu) {
            stack[height] = vec2u(group.base, group.bits);
            height += 1u;
        }
        let hits = visit_wide(node, ray, farthest(trace));
        @if(counters) trace.cells += 1u;
        group = hits.inner;
        @if(resumes) if (level < MOST_LEVELS) {
            group.bits |= (level + 1u) << 8u;
            path[(level + 1u) / 8u] = with_trail_child(path[(level + 1u) / 8u], level + 1u, NO_CHILD);
        }
        var waiting = hits.leaves.bits;
        while (waiting != 0u) {
            let bit = firstTrailingBit(waiting);
            waiting &= waiting - 1u;
            trace = tested(trace, wide_entry(hits.leaves, bit), vec3i(0));
            @if(any_hit || whole_paths) if (trace.ended) {
                return trace;
            }
        }
        if (group.bits <= 0x00ffffffu) {
            if (height == 0u) {
                break;
            }
            height -= 1u;
            group = WideGroup(stack[height].x, stack[height].y);
        }
        @if(resumes) if (is_spent(trace)) {
            for (var word = 0u; word < TRAIL_WORDS; word++) {
                textureStore(trail, wait.texel, word, vec4u(path[word]));
            }
            wait_at(node, (group.bits >> 8u) & 0xffu);
            return trace;
        }
    }
    return trace;
}
