// The walk through the irregular grid (Pérard-Gayot, Kalojanov and Slusallek, 2017): its start, and one step.
//
// A ray is in a cell, whose box it leaves at once, and knows the virtual cell by which it came. Both ends of the step are
// integers: the plane that it crosses, and, along the other axes, a virtual cell that is neither outside of the box nor
// behind the one before. So no error grows along the walk, and every step goes forward.
//
// A walk is kept in as few registers as possible, since they decide how many rays a GPU runs at a time: coordinates of
// virtual cells are packed, and where the ray leaves its box is computed when it does.
//
// aside: a ray begins in the space around the grid, cell OUTSIDE, which lists the triangles that were set aside, and
// leaves it at the grid's box.

import package::constants::{INF, OUTSIDE};
import package::vector::{smallest3};
import package::grid::{grid, smallest_axis};
import package::grid_walk::{GridRay, enter_grid, clipped};

@group(1) @binding(22) var<storage, read> irregular_map: array<u32>;
// Two words with the first virtual cell, and the one after the last, 16 bits per coordinate, and where the list starts.
@group(1) @binding(23) var<storage, read> irregular_cells: array<vec4u>;
// Triangles; bit 31 marks the last of a list.
@group(1) @binding(24) var<storage, read> irregular_items: array<u32>;

struct VoxelWalk {
    // The virtual cell by which it came, packed.
    voxel: vec2u,
    cell: u32,
    // Start of the cell's list.
    first: u32,
    // The cell's box, as in `irregular_cells`.
    box: vec3u,
    inside: bool,
}

// How a ray leaves its cell's box, per axis.
struct VoxelExit {
    // The face that lies ahead.
    ahead: vec3i,
    // t at which the ray reaches it.
    tmax: vec3f,
}

fn packed_voxel(voxel: vec3i) -> vec2u {
    let at = vec3u(voxel);
    return vec2u(at.x | (at.y << 16u), at.z);
}

fn unpacked_voxel(voxel: vec2u) -> vec3i {
    return vec3i(vec3u(voxel.x & 0xffffu, voxel.x >> 16u, voxel.y));
}

// Integers below 2^23 as floats: as the last digits of 2^23 + i. Exact, and faster than a conversion, of which GPUs
// compute fewer per clock.
fn small_floats(i: vec3u) -> vec3f {
    return bitcast<vec3f>(i | vec3u(0x4b000000u)) - vec3f(8388608.0);
}

// The inverse, rounding down: the sum's last digit is worth 1, and it is rounded to nearest. An odd integer may become
// the one below, the cell on its other side, and numbers below 1/4 become -1. Numbers outside of 0 to 2^23 give some
// integer.
fn rounded_down(v: vec3f) -> vec3i {
    return bitcast<vec3i>(v + vec3f(8388607.5)) - vec3i(0x4b000000);
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
fn at_voxel(voxel: vec3i, cell: u32) -> VoxelWalk {
    let words = irregular_cells[cell];
    return VoxelWalk(packed_voxel(voxel), cell, words.w, words.xyz, true);
}

fn voxel_exit(walk: VoxelWalk, ray: GridRay) -> VoxelExit {
    let box = walk.box;
    let low = vec3u(box.x & 0xffffu, box.x >> 16u, box.y & 0xffffu);
    let high = vec3u(box.y >> 16u, box.z & 0xffffu, box.z >> 16u);
    let ahead = select(low, high, ray.inverse > vec3f(0.0));
    let t = (grid.width * small_floats(ahead) - ray.origin) * ray.inverse;
    let in_grid = select(t, vec3f(INF), ray.inverse == vec3f(0.0));
    @if(aside) let tmax = select(in_grid, vec3f(reached(ray)), walk.cell == OUTSIDE);
    @else let tmax = in_grid;
    return VoxelExit(vec3i(ahead), tmax);
}

// t at which a ray leaves the space around the grid: it enters the grid, or never does.
@if(aside)
fn reached(ray: GridRay) -> f32 {
    let box = clipped(ray);
    return select(INF, box.t, box.meets);
}

fn enter_irregular(ray: GridRay) -> VoxelWalk {
    @if(aside) return at_voxel(vec3i(0), OUTSIDE);
    @else return enter_cells(ray);
}

// The first cell of a ray in the grid.
fn enter_cells(ray: GridRay) -> VoxelWalk {
    let walk = enter_grid(ray);
    var entered = at_voxel(walk.cell, find_cell(walk.cell));
    entered.inside = walk.inside;
    return entered;
}

fn step_voxel(walk: VoxelWalk, exit: VoxelExit, ray: GridRay) -> VoxelWalk {
    @if(aside) if (walk.cell == OUTSIDE) {
        return enter_cells(ray);
    }
    let axis = smallest_axis(exit.tmax);
    let t = smallest3(exit.tmax);
    let position = (ray.origin + ray.direction * t) * grid.inverse_width;
    let is_up = ray.inverse > vec3f(0.0);
    // The virtual cells on both sides of the faces ahead.
    let last = select(exit.ahead, exit.ahead - vec3i(1), is_up);
    let beyond = select(exit.ahead - vec3i(1), exit.ahead, is_up);
    // Clamped to where the ray can be.
    let came_by = unpacked_voxel(walk.voxel);
    let place = clamp(rounded_down(position), min(came_by, last), max(came_by, last));
    let voxel = select(place, beyond, axis);
    if (!(t < INF && all(vec3u(voxel) < vec3u(grid.cells)))) {
        var left = walk;
        left.inside = false;
        return left;
    }
    return at_voxel(voxel, find_cell(voxel));
}
