// The grid's lists of triangles, and what follows when one ends.

import package::constants::{INF};
import package::state::{TRAV, ISECT_HIT, SHADE, BACKGROUND};

@group(1) @binding(4) var<storage, read> grid_cells: array<u32>;
@group(1) @binding(5) var<storage, read> grid_items: array<u32>;
@if(skip) @group(1) @binding(16) var<storage, read> grid_distances: array<u32>;

// Chessboard distance of an empty cell to the nearest one with a list; 0 for a cell with a list, or if no distances are
// known.
fn empty_distance(index: u32) -> i32 {
    @if(!skip) return 0;
    @else return i32((grid_distances[index / 4u] >> (8u * (index % 4u))) & 0xffu);
}

// The state after a cell's list has ended; exit is the t at which the ray leaves the cell.
fn list_ended(tag: u32, nearest_t: f32, exit: f32) -> u32 {
    @if(!in_cell && !any_hit) return select(TRAV, SHADE, tag == ISECT_HIT && nearest_t <= exit);
    // Nothing was hit, and hits behind the ray's end do not count.
    @if(!in_cell && any_hit) return select(TRAV, BACKGROUND, nearest_t <= exit);
    @if(in_cell) return select(TRAV, SHADE, tag == ISECT_HIT);
}
