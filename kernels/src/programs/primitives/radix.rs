//! CPU reference of `radix.wgsl`: the digits of the sort.

/// Bits of a digit.
pub const DIGIT_BITS: u32 = 4;
/// Values that a digit has.
pub const DIGITS: usize = 1 << DIGIT_BITS;

/// Number of digits to sort keys below a number by: as many as the largest of them has.
#[must_use]
pub fn digits_of(keys_below: u32) -> u32 {
    (u32::BITS - keys_below.saturating_sub(1).leading_zeros()).div_ceil(DIGIT_BITS)
}

/// The digit of a key that a step sorts by.
#[must_use]
pub fn digit_of(key: u32, parameter: u32) -> usize {
    (key >> (DIGIT_BITS * parameter)) as usize & (DIGITS - 1)
}

/// Index of the tally of a digit in a block.
#[must_use]
pub fn tally_index(digit: usize, block: usize, blocks: usize) -> usize {
    digit * blocks + block
}
