// Moves the ray to its next cell, the one behind the face that it reaches first, or past a cube of empty cells if their
// distances are known.

import package::constants::{NOBODY, LIST_SIDE};
import package::state::{TRAV};
import package::ray::{load_origin, load_direction};
import package::grid::{cell_index, cell_of_index};
import package::grid_walk::{Walk, grid_ray, advance, leap, per_axis};
import package::grid_lists::{empty_distance};
import package::per_axis::{load_per_axis};
import package::arrival::{state, leave, arrive};
import package::live::{send, listed_texel};

fn step_cell(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV) {
        return NOBODY;
    }

    let ray = grid_ray(load_origin(texel), load_direction(texel));
    let index = textureLoad(state, texel, 2).x;
    var walk = Walk(cell_of_index(index), load_per_axis(texel), true);
    @if(skip) walk = leap(walk, max(empty_distance(index), 1), ray);
    @else walk = advance(walk, ray);
    if (!walk.inside) {
        return leave(texel);
    }
    return arrive(texel, cell_index(walk.cell), per_axis(walk));
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn traverse_grid(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    @if(live_lists) let texel = listed_texel(group, lane);
    @else let texel = id.xy;
    send(lane, texel, step_cell(texel));
}
