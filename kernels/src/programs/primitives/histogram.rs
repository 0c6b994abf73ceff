//! CPU reference of `histogram.wgsl`.

use super::radix::{DIGITS, digit_of, tally_index};
use super::{load, store};
use crate::scene_data::SceneData;
use crate::shared::launch::BLOCK;
use crate::tables::texels::Columns;

/// Counts how often each value of a digit occurs in each block of keys.
pub fn histogram(parameter: u32, key_in: &[u32], tally: &mut [u32]) {
    let blocks = key_in.len().div_ceil(BLOCK);
    for (block, keys) in key_in.chunks(BLOCK).enumerate() {
        let mut counts = [0; DIGITS];
        for &key in keys {
            counts[digit_of(key, parameter)] += 1;
        }
        for (digit, count) in counts.into_iter().enumerate() {
            if let Some(tally) = tally.get_mut(tally_index(digit, block, blocks)) {
                *tally = count;
            }
        }
    }
}

/// Runs a pass.
pub fn pass(columns: &mut dyn Columns, _: &SceneData) {
    let mut tally = load(columns, "tally", 0);
    histogram(columns.parameter(), &load(columns, "key_in", 0), &mut tally);
    store(columns, "tally", 0, tally);
}
