// The walk through a uniform grid (Amanatides and Woo, 1987): where it starts, and one step.
//
// robust: tmax follows from the integer cell each time, so no error grows along the walk; the origin
// is clipped to the grid; leaving is noticed per axis. paper: as Listing 1 of Mølhave's paper.

import package::constants::{INF, PARALLEL, PAPER_PARALLEL};

struct Grid {
    // Lower corner of cell (0, 0, 0), traced units.
    corner: vec3f,
    // Cells along each axis.
    cells: vec3i,
    // Size of a cell, traced units.
    width: vec3f,
    // 1 / width, rounded.
    inverse_width: vec3f,
}

@group(1) @binding(1) var<uniform> grid: Grid;

struct Walk {
    cell: vec3i,
    tmax: vec3f,
    inside: bool,
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

// Lower faces of a cell.
fn cell_plane(cell: vec3i) -> vec3f {
    return grid.corner + grid.width * vec3f(cell);
}

@if(robust)
fn inverse_direction(direction: vec3f) -> vec3f {
    // A parallel axis gets 0 here and INF below; 1 keeps the division harmless.
    let parallel = abs(direction) < vec3f(PARALLEL);
    return select(1.0 / select(direction, vec3f(1.0), parallel), vec3f(0.0), parallel);
}

// t at which the ray leaves the cell, per axis.
@if(robust)
fn cell_exit(cell: vec3i, origin: vec3f, inverse: vec3f) -> vec3f {
    let ahead = select(vec3i(0), vec3i(1), inverse > vec3f(0.0));
    let t = (cell_plane(cell + ahead) - origin) * inverse;
    return select(t, vec3f(INF), inverse == vec3f(0.0));
}

@if(robust)
fn enter_grid(origin: vec3f, direction: vec3f) -> Walk {
    let inverse = inverse_direction(direction);
    @if(clip) let near_plane = cell_plane(vec3i(0));
    @if(clip) let far_plane = cell_plane(grid.cells);
    @if(clip) let t0 = (near_plane - origin) * inverse;
    @if(clip) let t1 = (far_plane - origin) * inverse;
    // A parallel axis does not bound t: inside its slab always, outside never.
    @if(clip) let parallel = inverse == vec3f(0.0);
    @if(clip) let outside = parallel & ((origin < near_plane) | (origin > far_plane));
    @if(clip) let enter = select(min(t0, t1), vec3f(0.0), parallel);
    @if(clip) let leave = select(max(t0, t1), vec3f(INF), parallel);
    @if(clip) let t_enter = max(max(enter.x, enter.y), max(enter.z, 0.0));
    @if(clip) let t_leave = min(min(leave.x, leave.y), leave.z);
    @if(clip) let start = origin + direction * t_enter;
    @else let start = origin;
    let position = (start - grid.corner) * grid.inverse_width;
    let cell = clamp(vec3i(floor(position)), vec3i(0), grid.cells - vec3i(1));
    var walk = Walk(cell, cell_exit(cell, origin, inverse), true);
    // The negated comparison sends NaN outside.
    @if(clip) walk.inside = t_enter <= t_leave && !any(outside);
    return walk;
}

@if(robust)
fn advance(walk: Walk, origin: vec3f, direction: vec3f) -> Walk {
    let inverse = inverse_direction(direction);
    let axis = smallest_axis(walk.tmax);
    let forward = select(vec3i(-1), vec3i(1), inverse > vec3f(0.0));
    let cell = walk.cell + select(vec3i(0), forward, axis);
    let crossed = min(min(walk.tmax.x, walk.tmax.y), walk.tmax.z) < INF;
    return Walk(cell, cell_exit(cell, origin, inverse), crossed && is_in_grid(cell));
}

// Which axis is crossed next, in the order of Listing 1.
fn smallest_axis(tmax: vec3f) -> vec3<bool> {
    let x = tmax.x < tmax.y && tmax.x < tmax.z;
    let y = !(tmax.x < tmax.y) && tmax.y < tmax.z;
    return vec3<bool>(x, y, !x && !y);
}

@if(!robust)
fn enter_grid(origin: vec3f, direction: vec3f) -> Walk {
    // The paper's origin is relative to the grid's.
    let relative = origin - grid.corner;
    let cell = vec3i(floor(relative / grid.width));
    let plane = vec3f(cell) * grid.width + (1.0 + sign(direction)) * grid.width / 2.0;
    let parallel = abs(direction) < vec3f(PAPER_PARALLEL);
    let t = (plane - relative) / select(direction, vec3f(1.0), parallel);
    // An origin outside of the grid is not handled; only an index outside of the arrays is refused.
    return Walk(cell, select(t, vec3f(INF), parallel), is_index_in_range(cell));
}

@if(!robust)
fn advance(walk: Walk, origin: vec3f, direction: vec3f) -> Walk {
    let t_delta = abs(grid.width / direction);
    let axis = smallest_axis(walk.tmax);
    let cell = walk.cell + select(vec3i(0), vec3i(sign(direction)), axis);
    let tmax = select(walk.tmax, walk.tmax + t_delta, axis);
    return Walk(cell, tmax, is_index_in_range(cell));
}

// The paper's test for a ray that has left: on the + faces the index runs on into the next row.
@if(!robust)
fn is_index_in_range(cell: vec3i) -> bool {
    // In f32 as in the paper, and so without overflow for a cell far away.
    let index = f32(cell.x) + f32(grid.cells.x) * (f32(cell.y) + f32(grid.cells.y) * f32(cell.z));
    let count = f32(grid.cells.x) * f32(grid.cells.y) * f32(grid.cells.z);
    // Beyond 2^24 cells f32 rounds the two together; the integers keep the arrays' end.
    let in_arrays = cell_index(cell) < u32(grid.cells.x * grid.cells.y * grid.cells.z);
    return index < count && all(cell >= vec3i(0)) && in_arrays;
}
