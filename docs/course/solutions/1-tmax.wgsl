// A solution of exercise 1, tMax at the start.
//
// This is the kernel setup. For each ray, it finds the cell in which the walk through the grid begins.

import package::constants::{INF, LIST_SIDE, NOBODY};
import package::grid::{grid, cell_index};
import package::grid_walk::{enter_grid, grid_ray};
import package::live::{send, tiled_texel};
import package::ray::{load_direction, load_origin};
import package::state::{BACKGROUND, ISECT_NO_HIT, TRAV_SETUP};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, write>;

// For each axis, the t at which the ray crosses the next plane of the grid, when it starts in this cell.
//
// cell: which cell it is, counted from (0, 0, 0) at the grid's lower corner.
// origin: the ray's origin, measured from that corner, so the lower faces of cell (i, j, k) are at grid.width * (i, j, k).
// direction: the ray's direction. Its length is not 1.
fn first_tmax(cell: vec3i, origin: vec3f, direction: vec3f) -> vec3f {
    // The plane ahead: the upper face of the cell, or its lower face if the ray goes towards smaller coordinates.
    let ahead = select(vec3i(0), vec3i(1), direction > vec3f(0.0));
    let plane = grid.width * vec3f(cell + ahead);
    let t = (plane - origin) / direction;
    // A ray parallel to the planes of an axis never crosses one.
    return select(t, vec3f(INF), direction == vec3f(0.0));
}

// Returns the state in which the ray goes on.
fn set_up(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV_SETUP) {
        return NOBODY;
    }
    let origin = load_origin(texel) - grid.corner;
    let direction = load_direction(texel);
    // The first cell is found for you: exercise 6 is about that.
    let first = enter_grid(grid_ray(load_origin(texel), direction));
    if (!first.inside) {
        textureStore(state, texel, 0, vec4u(BACKGROUND));
        return BACKGROUND;
    }
    let t = first_tmax(first.cell, origin, direction);
    textureStore(tmax, texel, 0, vec4f(t.x));
    textureStore(tmax, texel, 1, vec4f(t.y));
    textureStore(tmax, texel, 2, vec4f(t.z));
    textureStore(state, texel, 2, vec4u(cell_index(first.cell)));
    textureStore(state, texel, 3, vec4u(0u));
    textureStore(state, texel, 0, vec4u(ISECT_NO_HIT));
    return ISECT_NO_HIT;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn setup(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let texel = tiled_texel(group, lane);
    send(lane, texel, set_up(texel));
}
