//! CPU reference of `radix.wgsl`: the digits of the sort.

/// Bits of a digit.
pub const DIGIT_BITS: u32 = 4;
/// Values that a digit has.
pub const DIGITS: usize = 1 << DIGIT_BITS;

/// Number of digits to sort cells by: as many as the last cell's index has.
#[must_use]
pub fn digits_of(cells: u32) -> u32 {
    (u32::BITS - cells.saturating_sub(1).leading_zeros()).div_ceil(DIGIT_BITS)
}

/// The digit of a cell index that a step sorts by.
#[must_use]
pub fn digit_of(cell: u32, parameter: u32) -> usize {
    (cell >> (DIGIT_BITS * parameter)) as usize & (DIGITS - 1)
}

/// Index of the tally of a digit in a block.
#[must_use]
pub fn tally_index(digit: usize, block: usize, blocks: usize) -> usize {
    digit * blocks + block
}
