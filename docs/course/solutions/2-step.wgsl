// A solution of exercise 2, one step.
//
// This is the kernel traverse_grid. It moves a ray whose list of triangles has ended to its next cell.

import package::arrival::{arrive, leave, state};
import package::constants::{LIST_SIDE, NOBODY};
import package::grid::{cell_index, cell_of_index, grid, is_index_in_range};
import package::live::{listed_texel, send};
import package::per_axis::{load_per_axis};
import package::ray::{load_direction};
import package::state::{TRAV};

// Where a ray is on its walk.
struct Place {
    cell: vec3i,
    // For each axis, the t at which the ray crosses the next plane of the grid.
    tmax: vec3f,
}

// One iteration of the loop: the cell behind the plane that the ray crosses first, and tMax there.
//
// forward: for each axis, 1 if the ray goes towards larger coordinates, else -1.
// t_delta: for each axis, the t between two planes of the grid.
fn next_step(here: Place, forward: vec3i, t_delta: vec3f) -> Place {
    var next = here;
    if (here.tmax.x < here.tmax.y && here.tmax.x < here.tmax.z) {
        next.cell.x += forward.x;
        next.tmax.x += t_delta.x;
    } else if (!(here.tmax.x < here.tmax.y) && here.tmax.y < here.tmax.z) {
        next.cell.y += forward.y;
        next.tmax.y += t_delta.y;
    } else {
        next.cell.z += forward.z;
        next.tmax.z += t_delta.z;
    }
    return next;
}

// Returns the state in which the ray goes on.
fn step_cell(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV) {
        return NOBODY;
    }
    let direction = load_direction(texel);
    let forward = select(vec3i(-1), vec3i(1), direction > vec3f(0.0));
    let here = Place(cell_of_index(textureLoad(state, texel, 2).x), load_per_axis(texel));
    let next = next_step(here, forward, abs(grid.width / direction));
    if (!is_index_in_range(next.cell)) {
        return leave(texel);
    }
    return arrive(texel, cell_index(next.cell), next.tmax);
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn traverse_grid(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let texel = listed_texel(group, lane);
    send(lane, texel, step_cell(texel));
}
