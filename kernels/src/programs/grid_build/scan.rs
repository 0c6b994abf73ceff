//! CPU reference of `scan.wgsl`.

use crate::shared::launch::BLOCK;

/// Values of a thread.
pub const EACH: u32 = 64;
/// Values of a block: those of a workgroup.
pub const SCAN_BLOCK: usize = BLOCK * EACH as usize;

/// Turns the values of each block into the sums of those before them, and keeps each block's own sum. Sums that are too
/// large are `u32::MAX`.
pub fn scan(values: &mut [u32], sums: &mut [u32]) {
    for (block, sum) in values.chunks_mut(SCAN_BLOCK).zip(sums) {
        *sum = 0;
        for value in block {
            let before = *sum;
            *sum = before.saturating_add(*value);
            *value = before;
        }
    }
}
