//! CPU reference of `compact.wgsl`.

use super::{layers, load, store};
use crate::scene_data::SceneData;
use crate::tables::texels::Columns;

/// Moves the values that are kept side by side. `place` holds the prefix sums of ones, for what is kept, and zeros.
pub fn compact(place: &[u32], total: u32, value_in: &[u32], value_out: &mut [u32]) {
    let next = place.iter().skip(1).copied().chain([total]);
    for ((&to, next), &value) in place.iter().zip(next).zip(value_in) {
        // If somebody has edited the streams, writes outside of them are ignored, as on a device.
        if let Some(kept) = value_out.get_mut(to as usize).filter(|_| next != to) {
            *kept = value;
        }
    }
}

/// Runs a pass.
pub fn pass(columns: &mut dyn Columns, _: &SceneData) {
    let (place, total) = (load(columns, "place", 0), load(columns, "total", 0));
    let total = total.first().copied().unwrap_or(0);
    for layer in 0..layers(columns, "value_in") {
        let mut value_out = load(columns, "value_out", layer);
        compact(&place, total, &load(columns, "value_in", layer), &mut value_out);
        store(columns, "value_out", layer, value_out);
    }
}
