// The walk through a uniform grid as a 3D-DDA (Fujimoto, Tanaka and Iwata, 1986), with the paper's rules: its start, and
// one step.

import package::dda::{slopes, first_control, crossed_axis, next_control};
import package::grid::{grid, is_index_in_range};

// A ray, and the values that each of its steps needs.
struct GridRay {
    // Relative to the grid's corner.
    origin: vec3f,
    direction: vec3f,
    // Cells along each axis per cell along the driving axis.
    slope: vec3f,
}

struct Walk {
    cell: vec3i,
    // How far the ray has gone past each axis's next face at that of the driving axis, in cells.
    control: vec3f,
    inside: bool,
}

// What decides by which face the ray leaves its cell, per axis.
fn per_axis(walk: Walk) -> vec3f {
    return walk.control;
}

fn grid_ray(origin: vec3f, direction: vec3f) -> GridRay {
    return GridRay(origin - grid.corner, direction, slopes(direction, grid.width));
}

fn enter_grid(ray: GridRay) -> Walk {
    let position = ray.origin / grid.width;
    let cell = vec3i(floor(position));
    return Walk(cell, first_control(position, cell, ray.direction, ray.slope), is_index_in_range(cell));
}

fn advance(walk: Walk, ray: GridRay) -> Walk {
    let axis = crossed_axis(walk.control, ray.slope);
    let cell = walk.cell + select(vec3i(0), vec3i(sign(ray.direction)), axis);
    return Walk(cell, next_control(walk.control, ray.slope, axis), is_index_in_range(cell));
}

// Empty cells are not skipped.
fn next_cell(walk: Walk, distance: i32, ray: GridRay) -> Walk {
    return advance(walk, ray);
}
