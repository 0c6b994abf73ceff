// The list of a cell of a uniform grid.

import package::grid_lists::{grid_cells, grid_items};
import package::intersect_entry::{Entry};
import package::intersect_cell_end::{after_cell};

struct List {
    first: u32,
    count: u32,
}

fn list_of(cell: u32) -> List {
    let first = grid_cells[cell];
    return List(first, grid_cells[cell + 1u] - first);
}

fn has_item(list: List, item: u32) -> bool {
    return item < list.count;
}

fn entry_of(list: List, item: u32) -> Entry {
    return Entry(grid_items[list.first + item], item + 1u >= list.count);
}

fn after_list(texel: vec2u, tag: u32, nearest_t: f32) -> u32 {
    return after_cell(texel, tag, nearest_t);
}
