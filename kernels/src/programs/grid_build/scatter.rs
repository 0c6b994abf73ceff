//! CPU reference of `scatter.wgsl`.

use super::radix::{DIGITS, digit_of, tally_index};
use crate::shared::launch::BLOCK;

/// Moves each reference to its place by one digit of its cell index. `tally` holds the prefix sums of all counts.
pub fn scatter(
    parameter: u32,
    cell_in: &[u32],
    triangle_in: &[u32],
    tally: &[u32],
    cell_out: &mut [u32],
    triangle_out: &mut [u32],
) {
    let blocks = cell_in.len().div_ceil(BLOCK);
    for (block, (cells, triangles)) in cell_in.chunks(BLOCK).zip(triangle_in.chunks(BLOCK)).enumerate() {
        let mut rank = [0; DIGITS];
        for (&cell, &triangle) in cells.iter().zip(triangles) {
            let digit = digit_of(cell, parameter);
            let first = tally.get(tally_index(digit, block, blocks)).copied().unwrap_or(u32::MAX);
            let to = first as usize + rank[digit];
            rank[digit] += 1;
            // If somebody has edited the streams, writes outside of them are ignored, as on a device.
            if let (Some(cell_to), Some(triangle_to)) = (cell_out.get_mut(to), triangle_out.get_mut(to)) {
                (*cell_to, *triangle_to) = (cell, triangle);
            }
        }
    }
}
