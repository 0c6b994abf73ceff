// Which leaves are merged: the first two of a row of leaves that each wish to be merged with the next one.

import package::leaf::{load};

@group(0) @binding(8) var neighbor: texture_2d_array<u32>;
@group(0) @binding(9) var wished: texture_2d_array<u32>;

const NOBODY: u32 = 0xffffffffu;

// Whether the leaf before wishes to be merged with this one.
fn is_wished_for(leaf: u32) -> bool {
    let before = load(neighbor, leaf, 1u);
    return before != NOBODY && load(wished, before, 0u) == leaf;
}

// Whether the leaf after this one is merged into it.
fn absorbs(leaf: u32) -> bool {
    return load(wished, leaf, 0u) != NOBODY && !is_wished_for(leaf);
}

// Whether this leaf is merged into the one before it.
fn is_absorbed(leaf: u32) -> bool {
    return is_wished_for(leaf) && absorbs(load(neighbor, leaf, 1u));
}
