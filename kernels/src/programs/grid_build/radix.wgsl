// The digits of a radix sort, lowest first, and where a block's count of each is (Satish, Harris, Garland 2009): all counts
// of one digit lie side by side, so that prefix sums of them are where each block's references with that digit go.

import package::launch::{launch};

const DIGIT_BITS: u32 = 4u;
const DIGITS: u32 = 16u;

// The digit that this step sorts by.
fn digit_of(cell: u32) -> u32 {
    return (cell >> (DIGIT_BITS * launch.parameter)) & (DIGITS - 1u);
}

// Where the tally of a digit in a block is.
fn tally_index(digit: u32, block: u32) -> u32 {
    return digit * launch.blocks + block;
}
