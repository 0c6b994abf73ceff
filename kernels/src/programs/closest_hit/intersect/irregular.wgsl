// The list of a cell of an irregular grid: its last entry is marked.

import package::constants::{NO_LIST, LAST_ITEM};
import package::irregular_walk::{irregular_cells, irregular_items};
import package::intersect_entry::{Entry};
import package::intersect_cell_end::{after_cell};

struct List {
    first: u32,
}

fn list_of(cell: u32) -> List {
    return List(irregular_cells[cell].w);
}

fn has_item(list: List, item: u32) -> bool {
    return list.first != NO_LIST;
}

fn entry_of(list: List, item: u32) -> Entry {
    let entry = irregular_items[list.first + item];
    return Entry(entry & ~LAST_ITEM, (entry & LAST_ITEM) != 0u);
}

fn after_list(texel: vec2u, tag: u32, nearest_t: f32) -> u32 {
    return after_cell(texel, tag, nearest_t);
}
