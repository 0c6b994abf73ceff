// At the hit of a path, after its shadow ray: adds the light if nothing is in its way, and sends the path on, or ends it.

import package::at_hit::{end, go_on, light_so_far, vertex_of_hit};
@if(counters) import package::at_hit::{cost_of_shadow};
import package::bounced::{state, hit, bounce, carried_at, spend};
import package::constants::{DEPTH, LIST_SIDE, NOBODY, NO_TRIANGLE};
import package::state::{OCCLUDED, VISIBLE, SCATTER};
import package::live::{book, tiled_texel};
import package::scattered::{BY_DEPTH, BY_ESCAPE, Next, scattered};

fn next_bounce(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    let tag = textureLoad(state, texel, 0).x;
    if (tag != SCATTER && tag != OCCLUDED && tag != VISIBLE) {
        return NOBODY;
    }
    let depth = textureLoad(bounce, texel, 0).x;
    let carried = carried_at(texel, depth);
    let sum = light_so_far(texel, tag);
    let triangle = textureLoad(hit, texel, 2).x;
    var next: Next;
    next.ended = select(BY_DEPTH, BY_ESCAPE, triangle == NO_TRIANGLE);
    if (triangle != NO_TRIANGLE && depth < DEPTH) {
        next = scattered(vertex_of_hit(texel, depth, triangle, carried));
    }
    @if(counters) spend(texel, cost_of_shadow(texel, tag), depth == 0u, next.ended != 0u);
    if (next.ended != 0u) {
        return end(texel, next.ended, sum);
    }
    return go_on(texel, next, triangle, depth);
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn sample_bsdf(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    book(lane, next_bounce(tiled_texel(group, lane)));
}
