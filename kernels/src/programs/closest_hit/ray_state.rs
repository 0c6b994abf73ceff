//! A ray between two passes: its texels, decoded.

use super::states::{DONE, ISECT_HIT, ISECT_NO_HIT, STATES, TRAV};
use super::streams::{
    ACCUMULATED, ACCUMULATED_SAMPLES, COLOR, CONTROL, HIT, HIT_TRIANGLE, PREVIOUS, RAY_DIRECTION, RAY_INTERVAL,
    RAY_ORIGIN, STATE, STATE_CELL, STATE_ITEM, STATE_T, TMAX,
};
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::state::Tag;
use crate::tables::stream::{STATE_TAG, Stream};

/// A ray's texels after some pass, decoded. Lengths and t are in traced units, as in the streams.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RayState {
    /// Origin.
    pub origin: [f32; 3],
    /// Direction.
    pub direction: [f32; 3],
    /// The t between which hits count; absent if no ray of the run has an interval.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub interval: Option<[f32; 2]>,
    /// The tag's name.
    pub state: &'static str,
    /// Tag of the state stream.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub tag: Tag,
    /// Nearest t so far.
    pub t: Option<f32>,
    /// 1-D index of the cell, or index of the BVH's node.
    pub cell_index: u32,
    /// The BVH's previous node; `None` without a BVH.
    pub previous: Option<u32>,
    /// Offset into the cell's list.
    pub item: u32,
    /// t at which the ray leaves its cell, per axis; `None` for an axis along which it never does.
    pub tmax: [Option<f32>; 3],
    /// Control terms of a 3D-DDA, per axis, in cells; absent without one.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub control: Option<[f32; 3]>,
    /// Nearest triangle hit so far.
    pub triangle: Option<u32>,
    /// Weights of vertices 1 and 2 at the hit.
    pub barycentric: Option<[f32; 2]>,
    /// Linear colour.
    pub color: Option<[f32; 3]>,
    /// Samples in the pixel's mean; absent if a pixel has one.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub samples: Option<u32>,
}

impl RayState {
    /// The streams it is decoded from, as far as a run has them.
    pub const STREAMS: [Stream; 10] =
        [STATE, HIT, RAY_ORIGIN, RAY_DIRECTION, RAY_INTERVAL, TMAX, CONTROL, PREVIOUS, COLOR, ACCUMULATED];

    /// Decodes a ray's texels, one word per layer; `None` for a stream that the run leaves out.
    pub fn of<'a>(texel: impl Fn(Stream) -> Option<&'a [u32]>) -> Self {
        let word = |stream: Stream, layer: usize| {
            let absent = stream.info().unwritten[layer];
            texel(stream).and_then(|texel| texel.get(layer)).copied().unwrap_or(absent)
        };
        let floats = |stream: Stream| texel(stream).map(|t| [t[0], t[1], t[2]].map(f32::from_bits));
        let (tag, triangle) = (word(STATE, STATE_TAG), word(HIT, HIT_TRIANGLE));
        let t = f32::from_bits(word(STATE, STATE_T));
        let is_hit = triangle != NO_TRIANGLE;
        Self {
            origin: floats(RAY_ORIGIN).unwrap_or_default(),
            direction: floats(RAY_DIRECTION).unwrap_or_default(),
            interval: texel(RAY_INTERVAL).map(|t| [t[0], t[1]].map(f32::from_bits)),
            state: STATES.name(tag),
            tag,
            t: (t < INF).then_some(t),
            cell_index: word(STATE, STATE_CELL),
            item: word(STATE, STATE_ITEM),
            previous: texel(PREVIOUS).map(|texel| texel[0]),
            tmax: floats(TMAX).map_or([None; 3], |v| v.map(|t| (t < INF).then_some(t))),
            control: floats(CONTROL),
            triangle: is_hit.then_some(triangle),
            barycentric: is_hit.then(|| [word(HIT, 0), word(HIT, 1)].map(f32::from_bits)),
            color: if tag == DONE { floats(COLOR) } else { None },
            samples: texel(ACCUMULATED).map(|texel| f32::from_bits(texel[ACCUMULATED_SAMPLES]) as u32),
        }
    }

    /// Whether it is in a cell or at a node: its walk has begun and is not over.
    #[must_use]
    pub fn is_walking(&self) -> bool {
        matches!(self.tag, TRAV | ISECT_HIT | ISECT_NO_HIT)
    }

    /// What decides by which face the ray leaves its cell, per axis: the control terms of a 3D-DDA, or tMax.
    #[must_use]
    pub fn per_axis(&self) -> [Option<f32>; 3] {
        self.control.map_or(self.tmax, |control| control.map(Some))
    }
}
