// Which leaves are merged: the first two of a row of leaves that each wish to be merged with the next one.

import package::leaf::{load_at, place_in};

@group(0) @binding(8) var wished: texture_2d_array<u32>;
@group(0) @binding(9) var wished_by: texture_2d_array<u32>;

const NOBODY: u32 = 0xffffffffu;

// Where a leaf is in its streams.
fn place(leaf: u32) -> vec2u {
    return place_in(wished_by, leaf);
}

// Whether the leaf after this one is merged into it.
fn absorbs(leaf: vec2u) -> bool {
    return load_at(wished_by, leaf, 0u) == NOBODY && load_at(wished, leaf, 0u) != NOBODY;
}

// Whether this leaf is merged into the one that wishes to be merged with it.
fn is_absorbed(leaf: vec2u) -> bool {
    let before = load_at(wished_by, leaf, 0u);
    return before != NOBODY && load_at(wished_by, place(before), 0u) == NOBODY;
}
