// Moves the ray to its next cell, the one behind the face that it reaches first, or past a cube of empty cells if their
// distances are known.

import package::constants::{NOBODY, LIST_SIDE};
import package::state::{TRAV};
import package::ray::{load_origin, load_direction};
import package::grid_walk::{Walk, grid_ray, advance, cell_index, cell_of_index};
@if(skip) import package::grid_walk::{leap};
@if(skip) import package::grid_lists::{empty_distance};
import package::arrival::{state, leave, arrive};
@if(!dda) import package::arrival::{tmax};
@if(dda) import package::arrival::{control};
import package::live::{send};
@if(live_lists) import package::live::{listed_texel};

@if(!dda)
fn load_tmax(texel: vec2u) -> vec3f {
    return vec3f(
        textureLoad(tmax, texel, 0).x,
        textureLoad(tmax, texel, 1).x,
        textureLoad(tmax, texel, 2).x,
    );
}

@if(dda)
fn load_control(texel: vec2u) -> vec3f {
    return vec3f(
        textureLoad(control, texel, 0).x,
        textureLoad(control, texel, 1).x,
        textureLoad(control, texel, 2).x,
    );
}

fn step_cell(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV) {
        return NOBODY;
    }

    let ray = grid_ray(load_origin(texel), load_direction(texel));
    let index = textureLoad(state, texel, 2).x;
    @if(!dda) var walk = Walk(cell_of_index(index), load_tmax(texel), true);
    @else var walk = Walk(cell_of_index(index), load_control(texel), true);
    @if(skip) walk = leap(walk, max(empty_distance(index), 1), ray);
    @else walk = advance(walk, ray);
    if (!walk.inside) {
        return leave(texel);
    }
    @if(!dda) return arrive(texel, cell_index(walk.cell), walk.tmax);
    @else return arrive(texel, cell_index(walk.cell), walk.control);
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
