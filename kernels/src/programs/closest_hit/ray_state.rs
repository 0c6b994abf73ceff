//! A ray between two passes: its texels, decoded.

use super::states::{ALL, ISECT_HIT, ISECT_NO_HIT, SHADOW_ISECT, SHADOW_SETUP, SHADOW_TRAV, TRAV, VISIBLE};
use super::streams::{
    ACCUMULATED, ACCUMULATED_SAMPLES, BLOCKER, BOUNCE, COLOR, CONTROL, ENDED, HIT, HIT_TRIANGLE, LIGHT, PDF, PENDING,
    PREVIOUS, RADIANCE, RAY_DIRECTION, RAY_INTERVAL, RAY_ORIGIN, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, STATE_CELL,
    STATE_ITEM, STATE_T, SURFACE, THROUGHPUT, TMAX,
};
use crate::program::RayState;
use crate::program::decoding::{Decoding, Texel};
use crate::program::ray_state::Bounce;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::state::StateRole;
use crate::tables::stream::{STATE_TAG, Stream};

/// How rays are decoded: a shadow ray, while there is one, else the ray before it.
pub(in crate::programs) const DECODING: Decoding = Decoding {
    streams: &[
        STATE,
        HIT,
        RAY_ORIGIN,
        RAY_DIRECTION,
        RAY_INTERVAL,
        TMAX,
        CONTROL,
        PREVIOUS,
        COLOR,
        ACCUMULATED,
        SHADOW_ORIGIN,
        SHADOW_DIRECTION,
        SURFACE,
        BLOCKER,
        PENDING,
        LIGHT,
        BOUNCE,
        THROUGHPUT,
        RADIANCE,
        PDF,
        ENDED,
    ],
    decode,
    tested: super::explain::tested,
    tree: None,
    paths: None,
    others: &[],
};

fn decode(texel: Texel<'_>) -> RayState {
    let word = |stream: Stream, layer: usize| {
        let absent = stream.info().unwritten[layer];
        texel(stream).and_then(|texel| texel.get(layer)).copied().unwrap_or(absent)
    };
    let floats = |stream: Stream| texel(stream).map(|t| [t[0], t[1], t[2]].map(f32::from_bits));
    let tag = word(STATE, STATE_TAG);
    let is_shadow = (SHADOW_SETUP..=VISIBLE).contains(&tag);
    let [hit, origin, direction] =
        if is_shadow { [BLOCKER, SHADOW_ORIGIN, SHADOW_DIRECTION] } else { [HIT, RAY_ORIGIN, RAY_DIRECTION] };
    let triangle = word(hit, HIT_TRIANGLE);
    let t = f32::from_bits(word(STATE, STATE_T));
    let is_hit = triangle != NO_TRIANGLE;
    let of_tree = |bounce: &[u32]| Bounce {
        depth: bounce[0],
        waiting: bounce[1],
        throughput: floats(THROUGHPUT).filter(|_| bounce[0] > 0).unwrap_or([1.0; 3]),
        pdf: f32::from_bits(word(PDF, 0)),
        radiance: floats(RADIANCE).unwrap_or_default(),
        ended: word(ENDED, 0),
    };
    RayState {
        origin: floats(origin).unwrap_or_default(),
        direction: floats(direction).unwrap_or_default(),
        interval: texel(RAY_INTERVAL).filter(|_| !is_shadow).map(|t| [t[0], t[1]].map(f32::from_bits)),
        state: ALL.name(tag),
        tag,
        t: (t < INF).then_some(t),
        is_walking: matches!(tag, TRAV | ISECT_HIT | ISECT_NO_HIT | SHADOW_TRAV | SHADOW_ISECT),
        cell_index: word(STATE, STATE_CELL),
        item: word(STATE, STATE_ITEM),
        previous: texel(PREVIOUS).map(|texel| texel[0]),
        tmax: floats(TMAX).map_or([None; 3], |v| v.map(|t| (t < INF).then_some(t))),
        control: floats(CONTROL),
        triangle: is_hit.then_some(triangle),
        barycentric: is_hit.then(|| [word(hit, 0), word(hit, 1)].map(f32::from_bits)),
        color: if ALL.role(tag) == Some(StateRole::Finished) { floats(COLOR) } else { None },
        surface: is_shadow.then(|| word(SURFACE, 0)),
        light: is_shadow.then(|| word(LIGHT, 0)),
        pending: if is_shadow { floats(PENDING) } else { None },
        bounce: texel(BOUNCE).map(of_tree),
        samples: texel(ACCUMULATED).map(|texel| f32::from_bits(texel[ACCUMULATED_SAMPLES]) as u32),
        gather: None,
        photon: None,
    }
}
