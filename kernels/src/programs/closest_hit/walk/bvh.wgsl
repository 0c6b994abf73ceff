// Through a binary BVH: a step is eight nodes.

import package::constants::{NODES_A_STEP, NO_NODE};
import package::state::{SHADE};
import package::bvh_walk::{Visit, bvh_nodes, next_node, finite_inverse};
import package::scene::{scene};
import package::tested::{tested};
import package::tracing::{farthest, ended_as, is_spent};
import package::walk_place::{Place, waiting_item};

@group(0) @binding(4) var previous: texture_storage_2d_array<r32uint, read_write>;

fn walked(start: Place, texel: vec2u) -> Place {
    var place = start;
    let inverse = finite_inverse(place.trace.direction);
    var at = Visit(place.cell, textureLoad(previous, texel, 0).x, false);
    @if(resumes) var waits = false;
    for (var step = 0u; step < NODES_A_STEP * scene.steps && at.node != NO_NODE; step++) {
        @if(resumes) if (is_spent(place.trace)) {
            break;
        }
        @if(resumes) place.trace.turns += 1u;
        // A ray that waits at an item is already in its leaf.
        at.in_leaf = waiting_item(place) > 0u;
        if (!at.in_leaf) {
            at = next_node(at, place.trace.origin, place.trace.direction, inverse, farthest(place.trace));
            @if(counters) place.trace.cells += 1u;
        }
        if (at.in_leaf) {
            let node = bvh_nodes[at.node];
            let end = node.first + (node.link & 0x3fffffffu);
            for (var item = node.first + waiting_item(place); item < end; item++) {
                place.trace = tested(place.trace, item, vec3i(0));
                @if(any_hit) if (place.trace.ended) {
                    place.tag = SHADE;
                    return place;
                }
                @if(resumes) if (is_spent(place.trace) && item + 1u < end) {
                    place.item = item + 1u - node.first;
                    waits = true;
                    break;
                }
            }
        }
        @if(resumes) if (waits) {
            break;
        }
        @if(resumes) place.item = 0u;
    }
    if (at.node == NO_NODE) {
        place.tag = ended_as(place.trace);
    } else {
        place.cell = at.node;
        textureStore(previous, texel, 0, vec4u(at.previous));
    }
    return place;
}
