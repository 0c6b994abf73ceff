// Where a triangle is in a leaf's list, which ascends.

import package::leaf::{load};

@group(0) @binding(10) var item: texture_2d_array<u32>;

// How many of these references, one after the other, are of lower triangles.
fn lower(first: u32, references: u32, triangle: u32) -> u32 {
    var low = 0u;
    var high = references;
    while (low < high) {
        let middle = low + (high - low) / 2u;
        if (load(item, first + middle, 0u) < triangle) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

fn is_listed(first: u32, references: u32, triangle: u32) -> bool {
    let place = lower(first, references, triangle);
    return place < references && load(item, first + place, 0u) == triangle;
}
