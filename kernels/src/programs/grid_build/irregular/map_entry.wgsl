// An entry of the voxel map for a leaf, or for a node with which a block begins.

import package::build::{build};
import package::leaf::{load};
import package::tree::{NODE};

@group(0) @binding(13) var first_entry: texture_2d_array<u32>;
@group(0) @binding(14) var block_levels: texture_2d_array<u32>;

fn entry_of(below: u32) -> u32 {
    let index = below >> 1u;
    if ((below & NODE) == 0u) {
        return index << 2u;
    }
    let cells = build.cells.x * build.cells.y * build.cells.z;
    return ((cells + load(first_entry, index, 0u)) << 2u) | load(block_levels, index, 0u);
}
