//! A ray between two passes: its texels, decoded.

use super::states::{ISECT_HIT, ISECT_NO_HIT, STATES, TRAV};
use super::streams::{
    ACCUMULATED, ACCUMULATED_SAMPLES, COLOR, CONTROL, HIT, HIT_TRIANGLE, PREVIOUS, RAY_DIRECTION, RAY_INTERVAL,
    RAY_ORIGIN, STATE, STATE_CELL, STATE_ITEM, STATE_T, TMAX,
};
use crate::program::ray_state::{Decoding, RayState, Texel};
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::state::StateRole;
use crate::tables::stream::{STATE_TAG, Stream};

/// How rays are decoded.
pub(super) const DECODING: Decoding = Decoding {
    streams: &[STATE, HIT, RAY_ORIGIN, RAY_DIRECTION, RAY_INTERVAL, TMAX, CONTROL, PREVIOUS, COLOR, ACCUMULATED],
    decode,
    tested: super::explain::tested,
};

fn decode(texel: Texel<'_>) -> RayState {
    let word = |stream: Stream, layer: usize| {
        let absent = stream.info().unwritten[layer];
        texel(stream).and_then(|texel| texel.get(layer)).copied().unwrap_or(absent)
    };
    let floats = |stream: Stream| texel(stream).map(|t| [t[0], t[1], t[2]].map(f32::from_bits));
    let (tag, triangle) = (word(STATE, STATE_TAG), word(HIT, HIT_TRIANGLE));
    let t = f32::from_bits(word(STATE, STATE_T));
    let is_hit = triangle != NO_TRIANGLE;
    RayState {
        origin: floats(RAY_ORIGIN).unwrap_or_default(),
        direction: floats(RAY_DIRECTION).unwrap_or_default(),
        interval: texel(RAY_INTERVAL).map(|t| [t[0], t[1]].map(f32::from_bits)),
        state: STATES.name(tag),
        tag,
        t: (t < INF).then_some(t),
        is_walking: matches!(tag, TRAV | ISECT_HIT | ISECT_NO_HIT),
        cell_index: word(STATE, STATE_CELL),
        item: word(STATE, STATE_ITEM),
        previous: texel(PREVIOUS).map(|texel| texel[0]),
        tmax: floats(TMAX).map_or([None; 3], |v| v.map(|t| (t < INF).then_some(t))),
        control: floats(CONTROL),
        triangle: is_hit.then_some(triangle),
        barycentric: is_hit.then(|| [word(HIT, 0), word(HIT, 1)].map(f32::from_bits)),
        color: if STATES.role(tag) == Some(StateRole::Finished) { floats(COLOR) } else { None },
        samples: texel(ACCUMULATED).map(|texel| f32::from_bits(texel[ACCUMULATED_SAMPLES]) as u32),
    }
}
