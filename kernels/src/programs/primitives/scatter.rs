//! CPU reference of `scatter.wgsl`.

use super::radix::{DIGITS, digit_of, tally_index};
use super::{layers, load, store};
use crate::scene_data::SceneData;
use crate::shared::launch::BLOCK;
use crate::tables::texels::Columns;

/// Where each pair of key and value goes by one digit of the key. `tally` holds the prefix sums of all counts.
#[must_use]
pub fn places(parameter: u32, key_in: &[u32], tally: &[u32]) -> Vec<usize> {
    let blocks = key_in.len().div_ceil(BLOCK);
    let of_block = |(block, keys): (usize, &[u32])| {
        let mut rank = [0; DIGITS];
        let place = |&key: &u32| {
            let digit = digit_of(key, parameter);
            rank[digit] += 1;
            let first = tally.get(tally_index(digit, block, blocks)).copied().unwrap_or(u32::MAX);
            (first as usize).saturating_add(rank[digit] - 1)
        };
        keys.iter().map(place).collect::<Vec<_>>()
    };
    key_in.chunks(BLOCK).enumerate().flat_map(of_block).collect()
}

/// Moves values to their places.
pub fn scatter(places: &[usize], from: &[u32], to: &mut [u32]) {
    for (&place, &value) in places.iter().zip(from) {
        // If somebody has edited the streams, writes outside of them are ignored, as on a device.
        if let Some(to) = to.get_mut(place) {
            *to = value;
        }
    }
}

/// Runs a pass.
pub fn pass(columns: &mut dyn Columns, _: &SceneData) {
    let [keys, tally] = ["key_in", "tally"].map(|name| load(columns, name, 0));
    let places = places(columns.parameter(), &keys, &tally);
    let all = layers(columns, "value_in");
    let mut move_all = |from: &str, to: &str, layer| {
        let mut moved = load(columns, to, layer);
        scatter(&places, &load(columns, from, layer), &mut moved);
        store(columns, to, layer, moved);
    };
    move_all("key_in", "key_out", 0);
    (0..all).for_each(|layer| move_all("value_in", "value_out", layer));
}
