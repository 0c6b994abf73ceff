//! CPU reference of `scatter.wgsl`.

use super::radix::{DIGITS, digit_of, tally_index};
use super::{load, store};
use crate::scene_data::SceneData;
use crate::shared::launch::BLOCK;
use crate::tables::texels::Columns;

/// Moves each pair of key and value to its place by one digit of the key. `tally` holds the prefix sums of all counts.
pub fn scatter(
    parameter: u32,
    key_in: &[u32],
    value_in: &[u32],
    tally: &[u32],
    key_out: &mut [u32],
    value_out: &mut [u32],
) {
    let blocks = key_in.len().div_ceil(BLOCK);
    for (block, (keys, values)) in key_in.chunks(BLOCK).zip(value_in.chunks(BLOCK)).enumerate() {
        let mut rank = [0; DIGITS];
        for (&key, &value) in keys.iter().zip(values) {
            let digit = digit_of(key, parameter);
            let first = tally.get(tally_index(digit, block, blocks)).copied().unwrap_or(u32::MAX);
            let to = first as usize + rank[digit];
            rank[digit] += 1;
            // If somebody has edited the streams, writes outside of them are ignored, as on a device.
            if let (Some(key_to), Some(value_to)) = (key_out.get_mut(to), value_out.get_mut(to)) {
                (*key_to, *value_to) = (key, value);
            }
        }
    }
}

/// Runs a pass.
pub fn pass(columns: &mut dyn Columns, _: &SceneData) {
    let [keys, values, tally] = ["key_in", "value_in", "tally"].map(|name| load(columns, name, 0));
    let [mut key_out, mut value_out] = ["key_out", "value_out"].map(|name| load(columns, name, 0));
    scatter(columns.parameter(), &keys, &values, &tally, &mut key_out, &mut value_out);
    store(columns, "key_out", 0, key_out);
    store(columns, "value_out", 0, value_out);
}
