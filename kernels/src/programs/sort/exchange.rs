//! Twin of `exchange.wgsl`: compares two keys and exchanges them if they are out of order.

use crate::scene_data::SceneData;
use crate::tables::texels::Columns;

/// The element that a step of a stage compares an element with; beyond the end there may be none.
#[must_use]
pub fn partner(i: usize, parameter: u32) -> usize {
    let (stage, step) = (parameter / 32, parameter % 32);
    let mask = if step == 0 { (2 << stage) - 1 } else { 1 << (stage - step) };
    i ^ mask
}

/// Runs a pass.
pub fn exchange(columns: &mut dyn Columns, _: &SceneData) {
    let Some(key) = columns.stream("key") else { return };
    let elements = columns.len(key);
    for i in 0..elements {
        let j = partner(i, columns.parameter());
        if j <= i || j >= elements {
            continue;
        }
        let [here, there] = [i, j].map(|at| [0, 1].map(|layer| columns.load(key, layer, at)));
        if there < here {
            for (at, value) in [(i, there), (j, here)] {
                (0..).zip(value).for_each(|(layer, word)| columns.store(key, layer, at, word));
            }
        }
    }
}
