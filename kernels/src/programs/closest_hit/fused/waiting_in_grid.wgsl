// A ray in the grid between two dispatches of the fused kernel.

import package::grid::{grid, cell_of_index};
import package::grid_walk::{GridRay, Walk, enter_grid, cell_exit, per_axis};
import package::fused_waiting::{wait, wait_at};

@group(0) @binding(6) var place: texture_storage_2d_array<r32uint, read_write>;

// The first cell, or the one at which the ray waits.
fn first_cell(ray: GridRay) -> Walk {
    @if(resumes) if (wait.before) {
        return kept_walk(ray);
    }
    return enter_grid(ray);
}

@if(robust && !drifting)
fn kept_walk(ray: GridRay) -> Walk {
    let cell = cell_of_index(wait.cell);
    return Walk(cell, cell_exit(cell, ray), true);
}
@else
fn kept_walk(ray: GridRay) -> Walk {
    let x = textureLoad(place, wait.texel, 0).x;
    let y = textureLoad(place, wait.texel, 1).x;
    let z = textureLoad(place, wait.texel, 2).x;
    let along_x = textureLoad(place, wait.texel, 4).x;
    let along_y = textureLoad(place, wait.texel, 5).x;
    let along_z = textureLoad(place, wait.texel, 6).x;
    return Walk(vec3i(vec3u(x, y, z)), bitcast<vec3f>(vec3u(along_x, along_y, along_z)), true);
}

// How many more cells the ray may visit. robust leaves the grid long before; with the paper's rules a ray may wrap over a
// face again and again.
fn cells_left() -> i32 {
    @if(in_cell && resumes && (!robust || drifting)) if (wait.before) {
        return i32(textureLoad(place, wait.texel, 3).x);
    }
    @if(in_cell) return 4 * (grid.cells.x + grid.cells.y + grid.cells.z) + 64;
    @else return 0;
}

// Stores what cannot be computed from the cell's index: the coordinates if a ray wrapped over a face with the paper's
// rules, tmax if it is accumulated or control terms, and how many more cells are allowed.
fn keep_place(walk: Walk, left: i32) {
    textureStore(place, wait.texel, 0, vec4u(u32(walk.cell.x)));
    textureStore(place, wait.texel, 1, vec4u(u32(walk.cell.y)));
    textureStore(place, wait.texel, 2, vec4u(u32(walk.cell.z)));
    textureStore(place, wait.texel, 3, vec4u(u32(left)));
    let along = bitcast<vec3u>(per_axis(walk));
    textureStore(place, wait.texel, 4, vec4u(along.x));
    textureStore(place, wait.texel, 5, vec4u(along.y));
    textureStore(place, wait.texel, 6, vec4u(along.z));
}

fn wait_in(walk: Walk, left: i32, cell: u32, item: u32) {
    @if(!robust || drifting) keep_place(walk, left);
    wait_at(cell, item);
}
