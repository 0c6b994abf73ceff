// The walk through the irregular grid (Pérard-Gayot, Kalojanov and Slusallek, 2017): its start, and one step.
//
// A ray is in a cell, whose box it leaves at once, and knows the virtual cell by which it came. Both ends of the step are
// integers: the plane that it crosses, and, along the other axes, a virtual cell that is neither outside of the box nor
// behind the one before. So no error grows along the walk, and every step goes forward.
//
// aside: a ray begins in the space around the grid, cell OUTSIDE, which lists the triangles that were set aside, and
// leaves it at the grid's box.

import package::constants::{INF};
import package::vector::{smallest3};
import package::grid_walk::{GridRay, grid, enter_grid, cell_plane, smallest_axis};
@if(aside) import package::constants::{OUTSIDE};
@if(aside) import package::grid_walk::{clipped};

@group(1) @binding(22) var<storage, read> irregular_map: array<u32>;
// Two words with the first virtual cell, and the one after the last, 16 bits per coordinate, and where the list starts.
@group(1) @binding(23) var<storage, read> irregular_cells: array<vec4u>;
// Triangles; bit 31 marks the last of a list.
@group(1) @binding(24) var<storage, read> irregular_items: array<u32>;

struct VoxelWalk {
    voxel: vec3i,
    cell: u32,
    // Start of the cell's list.
    first: u32,
    // The faces of the cell's box that lie ahead, one per axis.
    ahead: vec3i,
    // t at which the ray leaves the box, per axis.
    tmax: vec3f,
    inside: bool,
}

// The cell to which a virtual cell belongs.
fn find_cell(voxel: vec3i) -> u32 {
    let at = vec3u(voxel);
    var shift = grid.levels;
    let size = vec3u(grid.cells) >> vec3u(shift);
    let top = at >> vec3u(shift);
    var entry = irregular_map[top.x + size.x * (top.y + size.y * top.z)];
    // Bits 0 and 1: how many levels the block of entries covers; 0 for a cell.
    while ((entry & 3u) != 0u) {
        let depth = entry & 3u;
        shift -= depth;
        let below = (at >> vec3u(shift)) & vec3u((1u << depth) - 1u);
        entry = irregular_map[(entry >> 2u) + below.x + ((below.y + (below.z << depth)) << depth)];
    }
    return entry >> 2u;
}

// In a cell, having come by a virtual cell.
fn at_voxel(voxel: vec3i, cell: u32, ray: GridRay) -> VoxelWalk {
    let words = irregular_cells[cell];
    let low = vec3i(vec3u(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu));
    let high = vec3i(vec3u(words.y >> 16u, words.z & 0xffffu, words.z >> 16u));
    let ahead = select(low, high, ray.inverse > vec3f(0.0));
    let t = (cell_plane(ahead) - ray.origin) * ray.inverse;
    let in_grid = select(t, vec3f(INF), ray.inverse == vec3f(0.0));
    @if(aside) let tmax = select(in_grid, vec3f(reached(ray)), cell == OUTSIDE);
    @else let tmax = in_grid;
    return VoxelWalk(voxel, cell, words.w, ahead, tmax, true);
}

// t at which a ray leaves the space around the grid: it enters the grid, or never does.
@if(aside)
fn reached(ray: GridRay) -> f32 {
    let box = clipped(ray);
    return select(INF, box.t, box.meets);
}

fn enter_irregular(ray: GridRay) -> VoxelWalk {
    @if(aside) return at_voxel(vec3i(0), OUTSIDE, ray);
    @else return enter_cells(ray);
}

// The first cell of a ray in the grid.
fn enter_cells(ray: GridRay) -> VoxelWalk {
    let walk = enter_grid(ray);
    var entered = at_voxel(walk.cell, find_cell(walk.cell), ray);
    entered.inside = walk.inside;
    return entered;
}

fn step_voxel(walk: VoxelWalk, ray: GridRay) -> VoxelWalk {
    @if(aside) if (walk.cell == OUTSIDE) {
        return enter_cells(ray);
    }
    let axis = smallest_axis(walk.tmax);
    let t = smallest3(walk.tmax);
    let position = (ray.origin + ray.direction * t) * grid.inverse_width;
    let is_up = ray.inverse > vec3f(0.0);
    // The virtual cells on both sides of the faces ahead.
    let last = select(walk.ahead, walk.ahead - vec3i(1), is_up);
    let beyond = select(walk.ahead - vec3i(1), walk.ahead, is_up);
    // Clamped to where the ray can be, which also makes rounding towards 0 the same as down.
    let place = clamp(vec3i(position), min(walk.voxel, last), max(walk.voxel, last));
    let voxel = select(place, beyond, axis);
    if (!(t < INF && all(vec3u(voxel) < vec3u(grid.cells)))) {
        var left = walk;
        left.inside = false;
        return left;
    }
    return at_voxel(voxel, find_cell(voxel), ray);
}
