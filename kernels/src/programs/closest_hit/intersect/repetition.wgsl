// Whether an earlier cell of the grid listed a triangle too: repeats the walk from its start, and looks into every list.
//
// resumes_scan: if this search may take more loop iterations than a dispatch allows, it continues in the next one, and
// the triangle is tested when the search ends.

import package::constants::{TURNS, NO_CELL};
import package::camera::{Ray};
import package::grid::{grid, cell_index, cell_of_index};
import package::grid_walk::{Walk, grid_ray, enter_grid, advance, per_axis};
import package::grid_lists::{grid_cells, grid_items};

@group(0) @binding(6) var scan: texture_storage_2d_array<r32uint, read_write>;

const NOT_REPEATED: u32 = 0u;
const REPEATED: u32 = 1u;
const NOT_KNOWN_YET: u32 = 2u;

// Whether a cell lists a triangle; lists are in ascending order.
fn is_listed(triangle: u32, cell: u32) -> bool {
    var low = grid_cells[cell];
    var high = grid_cells[cell + 1u];
    while (low < high) {
        let middle = low + (high - low) / 2u;
        if (grid_items[middle] < triangle) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low < grid_cells[cell + 1u] && grid_items[low] == triangle;
}

fn keep_scan(texel: vec2u, cell: u32, along: vec3f) {
    textureStore(scan, texel, 0, vec4u(cell));
    textureStore(scan, texel, 1, vec4u(bitcast<u32>(along.x)));
    textureStore(scan, texel, 2, vec4u(bitcast<u32>(along.y)));
    textureStore(scan, texel, 3, vec4u(bitcast<u32>(along.z)));
}

fn repetition(texel: vec2u, triangle: u32, cell: u32, ray: Ray) -> u32 {
    let ray_in_grid = grid_ray(ray.origin, ray.direction);
    var walk = enter_grid(ray_in_grid);
    let bound = grid.cells.x + grid.cells.y + grid.cells.z + 2;
    @if(resumes_scan) var turns = 0u;
    @if(resumes_scan) let begun = textureLoad(scan, texel, 0).x;
    @if(resumes_scan) if (begun != NO_CELL) {
        let x = textureLoad(scan, texel, 1).x;
        let y = textureLoad(scan, texel, 2).x;
        let z = textureLoad(scan, texel, 3).x;
        walk = Walk(cell_of_index(begun), bitcast<vec3f>(vec3u(x, y, z)), true);
    }
    for (var step = 0; step < bound && walk.inside; step++) {
        let index = cell_index(walk.cell);
        if (index == cell) {
            break;
        }
        @if(resumes_scan) if (turns >= TURNS) {
            keep_scan(texel, index, per_axis(walk));
            return NOT_KNOWN_YET;
        }
        // One iteration for the cell, and at most the bit length of its list for the binary search.
        @if(resumes_scan) turns += 1u + 32u - countLeadingZeros(grid_cells[index + 1u] - grid_cells[index]);
        if (is_listed(triangle, index)) {
            @if(resumes_scan) keep_scan(texel, NO_CELL, vec3f(0.0));
            return REPEATED;
        }
        walk = advance(walk, ray_in_grid);
    }
    @if(resumes_scan) keep_scan(texel, NO_CELL, vec3f(0.0));
    return NOT_REPEATED;
}
