// Which leaves are merged: the first two of a row of leaves that each wish to be merged with the next one.

import package::leaf::{load_at, place_in};

@group(0) @binding(8) var wished: texture_2d_array<u32>;
@group(0) @binding(9) var wished_by: texture_2d_array<u32>;

const NOBODY: u32 = 0xffffffffu;

// Where a leaf is in its streams.
fn place(leaf: u32) -> vec2u {
    return place_in(wished_by, leaf);
}

// What becomes of a leaf.
struct Merged {
    // Whether it is merged into the one that wishes to be merged with it.
    is_absorbed: bool,
    // The leaf after it, if that is merged into this one, or NOBODY; how many triangles both list.
    absorbed: u32,
    in_both: u32,
}

// What becomes of the leaf at a place. Its loads are side by side: what takes time is to wait for one after the other.
fn merged(leaf: vec2u) -> Merged {
    let before = load_at(wished_by, leaf, 0u);
    let wish = load_at(wished, leaf, 0u);
    let in_both = load_at(wished, leaf, 1u);
    if (before == NOBODY) {
        return Merged(false, wish, in_both);
    }
    return Merged(load_at(wished_by, place(before), 0u) == NOBODY, NOBODY, 0u);
}
