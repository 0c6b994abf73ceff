// Which leaves may be divided, and when.

import package::build::{build};
import package::leaf::{STAYS, load_at, level_of, even_of};

@group(0) @binding(14) var halving: texture_2d_array<u32>;

// Longer lists are divided beyond the levels that are divided anyway.
const SHORT: u32 = 8u;

const MOST_LEVELS: u32 = 32u;

// Whether a leaf's turn has come. Shallow octrees wait for the deepest one: each halving moves all leaves, so their number
// should stay small for as long as possible.
fn is_its_turn(levels: u32) -> bool {
    let done = load_at(halving, vec2u(0u), 0u);
    // Clamped, since the stream may have been edited: otherwise leaves could wait almost forever.
    let depth = min(load_at(halving, vec2u(0u), 1u), MOST_LEVELS);
    return level_of(levels) + depth <= done + even_of(levels);
}

fn may_be_divided(levels: u32, length: u32) -> bool {
    let level = level_of(levels);
    if (level >= build.levels || (levels & STAYS) != 0u) {
        return false;
    }
    if (level < even_of(levels)) {
        return length > 1u;
    }
    return (build.flags & 1u) != 0u && length > SHORT;
}
