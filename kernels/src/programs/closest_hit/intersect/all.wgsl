// All triangles are one list.

import package::state::{ISECT_HIT, SHADE, BACKGROUND};
import package::scene::{scene};
import package::intersect_entry::{Entry};

struct List {
    count: u32,
}

fn list_of(cell: u32) -> List {
    return List(scene.triangles);
}

fn has_item(list: List, item: u32) -> bool {
    return item < list.count;
}

fn entry_of(list: List, item: u32) -> Entry {
    return Entry(item, item + 1u >= list.count);
}

fn after_list(texel: vec2u, tag: u32, nearest_t: f32) -> u32 {
    return select(BACKGROUND, SHADE, tag == ISECT_HIT);
}
