// The walk through a uniform grid (Amanatides and Woo, 1987) as in Listing 1 of Mølhave's paper: its start, and one step.

import package::constants::{INF, PAPER_PARALLEL};
import package::grid::{grid, is_index_in_range, smallest_axis};

// A ray, and the values that each of its steps needs.
struct GridRay {
    // Relative to the grid's corner.
    origin: vec3f,
    direction: vec3f,
    // The t between two planes of an axis.
    t_delta: vec3f,
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
    return GridRay(origin - grid.corner, direction, abs(grid.width / direction));
}

fn enter_grid(ray: GridRay) -> Walk {
    let direction = ray.direction;
    let cell = vec3i(floor(ray.origin / grid.width));
    let plane = vec3f(cell) * grid.width + (1.0 + sign(direction)) * grid.width / 2.0;
    let parallel = abs(direction) < vec3f(PAPER_PARALLEL);
    let t = (plane - ray.origin) / select(direction, vec3f(1.0), parallel);
    // Origins outside of the grid are not handled; only an index outside of the arrays is rejected.
    return Walk(cell, select(t, vec3f(INF), parallel), is_index_in_range(cell));
}

fn advance(walk: Walk, ray: GridRay) -> Walk {
    let axis = smallest_axis(walk.tmax);
    let cell = walk.cell + select(vec3i(0), vec3i(sign(ray.direction)), axis);
    let tmax = select(walk.tmax, walk.tmax + ray.t_delta, axis);
    return Walk(cell, tmax, is_index_in_range(cell));
}

// Empty cells are not skipped.
fn next_cell(walk: Walk, distance: i32, ray: GridRay) -> Walk {
    return advance(walk, ray);
}
