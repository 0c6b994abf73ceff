// Exercise 6: a resolution. Write cell_of and index_of; 6-resolution.md says what they are.
//
// This is the kernel setup. For each ray, it finds the cell in which the walk through the grid begins.

import package::constants::{LIST_SIDE, NOBODY};
import package::grid::{cell_plane, grid};
import package::grid_walk::{cell_exit, clipped, grid_ray};
import package::live::{send, tiled_texel};
import package::ray::{load_direction, load_origin};
import package::state::{BACKGROUND, ISECT_NO_HIT, TRAV_SETUP};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, write>;

// The cell that contains a point, in a box that is divided into cells.x by cells.y by cells.z cells of the same size.
//
// point: measured from the box's lower corner. Every point is in some cell: one on the box's upper face, or beyond it by a
// rounding error, is in the last.
// size: the size of the box along each axis.
fn cell_of(point: vec3f, size: vec3f, cells: vec3i) -> vec3i {
    // HOLE: everything is in the first cell.
    return vec3i(0);
}

// The place of a cell in an array of all of them: first a row along x, then the next row along y, then the next layer along z.
fn index_of(cell: vec3i, cells: vec3i) -> u32 {
    // HOLE
    return 0u;
}

// Returns the state in which the ray goes on.
fn set_up(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV_SETUP) {
        return NOBODY;
    }
    let ray = grid_ray(load_origin(texel), load_direction(texel));
    let box = clipped(ray);
    if (!box.meets) {
        textureStore(state, texel, 0, vec4u(BACKGROUND));
        return BACKGROUND;
    }
    let start = ray.origin + ray.direction * box.t;
    let cell = cell_of(start, cell_plane(grid.cells), grid.cells);
    let t = cell_exit(cell, ray);
    textureStore(tmax, texel, 0, vec4f(t.x));
    textureStore(tmax, texel, 1, vec4f(t.y));
    textureStore(tmax, texel, 2, vec4f(t.z));
    textureStore(state, texel, 2, vec4u(index_of(cell, grid.cells)));
    textureStore(state, texel, 3, vec4u(0u));
    textureStore(state, texel, 0, vec4u(ISECT_NO_HIT));
    return ISECT_NO_HIT;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn setup(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let texel = tiled_texel(group, lane);
    send(lane, texel, set_up(texel));
}
