// Which leaves may be divided.

import package::build::{build};
import package::leaf::{STAYS, level_of, even_of};

// Longer lists are divided beyond the levels that are divided anyway.
const SHORT: u32 = 8u;

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
