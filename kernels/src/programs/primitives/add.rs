//! CPU reference of `add.wgsl`.

use super::scan::SCAN_BLOCK;
use super::{layers, load, store};
use crate::scene_data::SceneData;
use crate::tables::texels::Columns;

/// Adds to each value the sum of all blocks before its own.
pub fn add(values: &mut [u32], sums: &[u32]) {
    for (block, &before) in values.chunks_mut(SCAN_BLOCK).zip(sums) {
        for value in block {
            *value = before.saturating_add(*value);
        }
    }
}

/// Runs a pass, each layer for itself.
pub fn pass(columns: &mut dyn Columns, _: &SceneData) {
    for layer in 0..layers(columns, "values") {
        let mut values = load(columns, "values", layer);
        add(&mut values, &load(columns, "sums", layer));
        store(columns, "values", layer, values);
    }
}
