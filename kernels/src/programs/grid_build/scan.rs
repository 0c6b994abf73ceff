//! CPU reference of `scan.wgsl`.

use crate::shared::launch::BLOCK;

/// Values per thread.
pub const EACH: u32 = 32;
/// Values per block, that is per workgroup.
pub const SCAN_BLOCK: usize = BLOCK * EACH as usize;

/// Replaces the values in each block by the sums of those before them, and stores each block's own sum. Sums saturate
/// at `u32::MAX`.
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
