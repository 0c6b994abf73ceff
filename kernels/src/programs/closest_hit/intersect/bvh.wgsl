// The list of a leaf of a BVH.

import package::state::{TRAV};
import package::bvh_walk::{bvh_nodes};
import package::intersect_entry::{Entry};

@group(1) @binding(19) var<storage, read> bvh_items: array<u32>;

struct List {
    first: u32,
    count: u32,
}

fn list_of(leaf: u32) -> List {
    return List(bvh_nodes[leaf].first, bvh_nodes[leaf].link & 0x3fffffffu);
}

fn has_item(list: List, item: u32) -> bool {
    return item < list.count;
}

fn entry_of(list: List, item: u32) -> Entry {
    return Entry(bvh_items[list.first + item], item + 1u >= list.count);
}

// A later leaf may have a nearer hit.
fn after_list(texel: vec2u, tag: u32, nearest_t: f32) -> u32 {
    return TRAV;
}
