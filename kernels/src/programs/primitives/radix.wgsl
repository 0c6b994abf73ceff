// The digits of a radix sort, lowest first, and the index of a block's count of each (Satish, Harris, Garland 2009):
// all counts of one digit are stored side by side, so their prefix sums are where each block's keys with that digit
// go.

import package::launch::{launch};

const DIGIT_BITS: u32 = 4u;
const DIGITS: u32 = 16u;

// The digit that this step sorts by.
fn digit_of(key: u32) -> u32 {
    return (key >> (DIGIT_BITS * launch.parameter)) & (DIGITS - 1u);
}

// Index of the tally of a digit in a block.
fn tally_index(digit: u32, block: u32) -> u32 {
    return digit * launch.blocks + block;
}
