//! CPU reference of `add.wgsl`.

use super::launch::BLOCK;

/// Adds to each value the sum of all blocks before its own.
pub fn add(values: &mut [u32], sums: &[u32]) {
    for (block, &before) in values.chunks_mut(BLOCK).zip(sums) {
        for value in block {
            *value = before.saturating_add(*value);
        }
    }
}
