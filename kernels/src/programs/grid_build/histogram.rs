//! CPU reference of `histogram.wgsl`.

use super::radix::{DIGITS, digit_of, tally_index};
use crate::shared::launch::BLOCK;

/// Counts how often each digit of the cell index occurs in each block of references.
pub fn histogram(parameter: u32, cell_in: &[u32], tally: &mut [u32]) {
    let blocks = cell_in.len().div_ceil(BLOCK);
    for (block, cells) in cell_in.chunks(BLOCK).enumerate() {
        let mut counts = [0; DIGITS];
        for &cell in cells {
            counts[digit_of(cell, parameter)] += 1;
        }
        for (digit, count) in counts.into_iter().enumerate() {
            if let Some(tally) = tally.get_mut(tally_index(digit, block, blocks)) {
                *tally = count;
            }
        }
    }
}
