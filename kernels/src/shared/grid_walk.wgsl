// The walk through a uniform grid (Amanatides and Woo, 1987; dda: Fujimoto, Tanaka and Iwata, 1986): its start, and one
// step.
//
// robust: tmax is computed from the integer cell each time, so errors do not grow along the walk; the origin is clipped
// to the grid; leaving is detected per axis. All positions are relative to the grid's corner, so that errors follow the
// ray's distance from the grid, not the grid's from the world's origin. paper: as in Listing 1 of Mølhave's paper.

import package::constants::{INF, PARALLEL, PAPER_PARALLEL};
import package::dda::{slopes, first_control, crossed_axis, next_control};

struct Grid {
    // Lower corner of cell (0, 0, 0), traced units.
    corner: vec3f,
    // Cells along each axis.
    cells: vec3i,
    // Halvings of an irregular grid's top-level cells.
    levels: u32,
    // Size of a cell, traced units.
    width: vec3f,
    // 1 / width, rounded.
    inverse_width: vec3f,
}

@group(1) @binding(1) var<uniform> grid: Grid;

// A ray, and the values that each of its steps needs.
struct GridRay {
    // Relative to the grid's corner.
    origin: vec3f,
    direction: vec3f,
    // 1 / direction, 0 along a parallel axis.
    @if(robust) inverse: vec3f,
    // The t between two planes of an axis.
    @if(!robust && !dda) t_delta: vec3f,
    // Cells along each axis per cell along the driving axis.
    @if(dda) slope: vec3f,
}

struct Walk {
    cell: vec3i,
    // t at which the ray leaves the cell, per axis.
    @if(!dda) tmax: vec3f,
    // How far the ray has gone past each axis's next face at that of the driving axis, in cells.
    @if(dda) control: vec3f,
    inside: bool,
}

fn grid_ray(origin: vec3f, direction: vec3f) -> GridRay {
    @if(robust) return GridRay(origin - grid.corner, direction, inverse_direction(direction));
    @if(!robust && !dda) return GridRay(origin - grid.corner, direction, abs(grid.width / direction));
    @if(dda) return GridRay(origin - grid.corner, direction, slopes(direction, grid.width));
}

fn cell_index(cell: vec3i) -> u32 {
    return u32(cell.x + grid.cells.x * (cell.y + grid.cells.y * cell.z));
}

fn cell_of_index(index: u32) -> vec3i {
    let i = i32(index);
    let row = i / grid.cells.x;
    return vec3i(i % grid.cells.x, row % grid.cells.y, row / grid.cells.y);
}

fn is_in_grid(cell: vec3i) -> bool {
    return all(cell >= vec3i(0)) && all(cell < grid.cells);
}

// Coordinates of a cell's lower faces, relative to the grid's corner: exact.
fn cell_plane(cell: vec3i) -> vec3f {
    return grid.width * vec3f(cell);
}

fn is_in_cell(position: vec3f, cell: vec3i) -> bool {
    let low = grid.corner + cell_plane(cell);
    return all(position >= low) && all(position <= low + grid.width);
}

fn inverse_direction(direction: vec3f) -> vec3f {
    // A parallel axis gets 0 here and INF below; 1 keeps the division harmless.
    let parallel = abs(direction) < vec3f(PARALLEL);
    return select(1.0 / select(direction, vec3f(1.0), parallel), vec3f(0.0), parallel);
}

// t at which the ray leaves the cell, per axis.
fn cell_exit(cell: vec3i, ray: GridRay) -> vec3f {
    let ahead = select(vec3i(0), vec3i(1), ray.inverse > vec3f(0.0));
    let t = (cell_plane(cell + ahead) - ray.origin) * ray.inverse;
    return select(t, vec3f(INF), ray.inverse == vec3f(0.0));
}

// t at which a ray enters the grid's box, 0 if it starts inside, and whether it meets the box at all.
struct Clipped {
    t: f32,
    meets: bool,
}

fn clipped(ray: GridRay) -> Clipped {
    let near_plane = cell_plane(vec3i(0));
    let far_plane = cell_plane(grid.cells);
    let t0 = (near_plane - ray.origin) * ray.inverse;
    let t1 = (far_plane - ray.origin) * ray.inverse;
    // A parallel axis does not bound t: the ray is inside its slab always or never.
    let parallel = ray.inverse == vec3f(0.0);
    let outside = parallel & ((ray.origin < near_plane) | (ray.origin > far_plane));
    let enter = select(min(t0, t1), vec3f(0.0), parallel);
    let leave = select(max(t0, t1), vec3f(INF), parallel);
    let t_enter = max(max(enter.x, enter.y), max(enter.z, 0.0));
    let t_leave = min(min(leave.x, leave.y), leave.z);
    // The negated comparison treats NaN as outside.
    return Clipped(t_enter, t_enter <= t_leave && !any(outside));
}

@if(robust)
fn enter_grid(ray: GridRay) -> Walk {
    @if(clip) let box = clipped(ray);
    @if(clip) let start = ray.origin + ray.direction * box.t;
    @else let start = ray.origin;
    let position = start * grid.inverse_width;
    let cell = clamp(vec3i(floor(position)), vec3i(0), grid.cells - vec3i(1));
    var walk = Walk(cell, cell_exit(cell, ray), true);
    @if(clip) walk.inside = box.meets;
    return walk;
}

@if(robust)
fn advance(walk: Walk, ray: GridRay) -> Walk {
    let axis = smallest_axis(walk.tmax);
    let forward = select(vec3i(-1), vec3i(1), ray.inverse > vec3f(0.0));
    let cell = walk.cell + select(vec3i(0), forward, axis);
    let crossed = min(min(walk.tmax.x, walk.tmax.y), walk.tmax.z) < INF;
    @if(drifting) let tmax = select(walk.tmax, walk.tmax + abs(grid.width * ray.inverse), axis);
    @else let tmax = cell_exit(cell, ray);
    return Walk(cell, tmax, crossed && is_in_grid(cell));
}

// Leaves a cube of empty cells at once (proximity clouds, Cohen and Sheffer, 1994): every cell that is
// fewer than `distance` cells away along each axis is empty. A leap of distance 1 is a step.
fn leap(walk: Walk, distance: i32, ray: GridRay) -> Walk {
    let forward = select(vec3i(-1), vec3i(1), ray.inverse > vec3f(0.0));
    let last = walk.cell + forward * (distance - 1);
    let exit = cell_exit(last, ray);
    let axis = smallest_axis(exit);
    let t = min(min(exit.x, exit.y), exit.z);
    // As where the ray entered the grid; clamped, so that rounding cannot move it out of the cube or backwards.
    let position = (ray.origin + ray.direction * t) * grid.inverse_width;
    let place = clamp(vec3i(floor(position)), min(walk.cell, last), max(walk.cell, last));
    let cell = select(place, last + forward, axis);
    return Walk(cell, cell_exit(cell, ray), t < INF && is_in_grid(cell));
}

// The next cell, or past a cube of empty ones if its size is known: `distance` is that of `leap`, 0 in a cell with a
// list.
fn next_cell(walk: Walk, distance: i32, ray: GridRay) -> Walk {
    @if(skip) if (distance > 1) {
        return leap(walk, distance, ray);
    }
    return advance(walk, ray);
}

// What decides by which face the ray leaves its cell, per axis.
fn per_axis(walk: Walk) -> vec3f {
    @if(!dda) return walk.tmax;
    @else return walk.control;
}

// The axis that is crossed next, with ties in the order of Listing 1.
fn smallest_axis(tmax: vec3f) -> vec3<bool> {
    let x = tmax.x < tmax.y && tmax.x < tmax.z;
    let y = !(tmax.x < tmax.y) && tmax.y < tmax.z;
    return vec3<bool>(x, y, !x && !y);
}

@if(!robust && !dda)
fn enter_grid(ray: GridRay) -> Walk {
    let direction = ray.direction;
    let cell = vec3i(floor(ray.origin / grid.width));
    let plane = vec3f(cell) * grid.width + (1.0 + sign(direction)) * grid.width / 2.0;
    let parallel = abs(direction) < vec3f(PAPER_PARALLEL);
    let t = (plane - ray.origin) / select(direction, vec3f(1.0), parallel);
    // Origins outside of the grid are not handled; only an index outside of the arrays is rejected.
    return Walk(cell, select(t, vec3f(INF), parallel), is_index_in_range(cell));
}

@if(!robust && !dda)
fn advance(walk: Walk, ray: GridRay) -> Walk {
    let axis = smallest_axis(walk.tmax);
    let cell = walk.cell + select(vec3i(0), vec3i(sign(ray.direction)), axis);
    let tmax = select(walk.tmax, walk.tmax + ray.t_delta, axis);
    return Walk(cell, tmax, is_index_in_range(cell));
}

@if(dda)
fn enter_grid(ray: GridRay) -> Walk {
    let position = ray.origin / grid.width;
    let cell = vec3i(floor(position));
    return Walk(cell, first_control(position, cell, ray.direction, ray.slope), is_index_in_range(cell));
}

@if(dda)
fn advance(walk: Walk, ray: GridRay) -> Walk {
    let axis = crossed_axis(walk.control, ray.slope);
    let cell = walk.cell + select(vec3i(0), vec3i(sign(ray.direction)), axis);
    return Walk(cell, next_control(walk.control, ray.slope, axis), is_index_in_range(cell));
}

// The paper's test for a ray that has left: beyond the upper faces the index continues in the next row.
fn is_index_in_range(cell: vec3i) -> bool {
    // In f32 as in the paper, and so without overflow for a cell far away.
    let index = f32(cell.x) + f32(grid.cells.x) * (f32(cell.y) + f32(grid.cells.y) * f32(cell.z));
    let count = f32(grid.cells.x) * f32(grid.cells.y) * f32(grid.cells.z);
    // Beyond 2^24 cells f32 may round index and count to the same number; the integers guard the arrays' end.
    let in_arrays = cell_index(cell) < u32(grid.cells.x * grid.cells.y * grid.cells.z);
    return index < count && all(cell >= vec3i(0)) && in_arrays;
}
