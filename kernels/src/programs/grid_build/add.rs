//! CPU reference of `add.wgsl`.

use super::scan::SCAN_BLOCK;

/// Adds to each value the sum of all blocks before its own.
pub fn add(values: &mut [u32], sums: &[u32]) {
    for (block, &before) in values.chunks_mut(SCAN_BLOCK).zip(sums) {
        for value in block {
            *value = before.saturating_add(*value);
        }
    }
}
