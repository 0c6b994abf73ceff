// The walk through a uniform grid (Amanatides and Woo, 1987) with robust rules: its start, and one step.
//
// tmax is computed from the integer cell each time, so errors do not grow along the walk; the origin is clipped to the
// grid; leaving is detected per axis. All positions are relative to the grid's corner, so that errors follow the ray's
// distance from the grid, not the grid's from the world's origin.
//
// drifting: tmax grows by tDelta per cell instead.

import package::constants::{INF, PARALLEL};
import package::grid::{grid, cell_plane, is_in_grid, smallest_axis};

// A ray, and the values that each of its steps needs.
struct GridRay {
    // Relative to the grid's corner.
    origin: vec3f,
    direction: vec3f,
    // 1 / direction, 0 along a parallel axis.
    inverse: vec3f,
}

struct Walk {
    cell: vec3i,
    // t at which the ray leaves the cell, per axis.
    tmax: vec3f,
    inside: bool,
}

// What decides by which face the ray leaves its cell, per axis.
fn per_axis(walk: Walk) -> vec3f {
    return walk.tmax;
}

fn grid_ray(origin: vec3f, direction: vec3f) -> GridRay {
    return GridRay(origin - grid.corner, direction, inverse_direction(direction));
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
