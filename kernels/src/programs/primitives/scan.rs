//! CPU reference of `scan.wgsl`.

use super::{layers, load, store};
use crate::scene_data::SceneData;
use crate::shared::launch::{BLOCK, MOST_ELEMENTS};
use crate::tables::texels::Columns;

/// Values per thread.
pub const EACH: u32 = 32;
/// Values per block, that is per workgroup.
pub const SCAN_BLOCK: usize = BLOCK * EACH as usize;

const _: () = assert!(MOST_ELEMENTS == (SCAN_BLOCK * SCAN_BLOCK) as u64, "blocks of blocks are one");

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

/// Runs a pass, each layer for itself.
pub fn pass(columns: &mut dyn Columns, _: &SceneData) {
    for layer in 0..layers(columns, "values") {
        let (mut values, mut sums) = (load(columns, "values", layer), load(columns, "sums", layer));
        scan(&mut values, &mut sums);
        store(columns, "values", layer, values);
        store(columns, "sums", layer, sums);
    }
}
