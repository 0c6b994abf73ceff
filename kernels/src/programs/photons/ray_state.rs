//! A ray from the camera or a photon between two passes: its texels, decoded.

use crate::program::RayState;
use crate::program::decoding::{Decoding, Texel};
use crate::program::ray_state::{Gather, Photon};
use crate::programs::closest_hit::ray_state::DECODING as OF_RAYS;
use crate::programs::closest_hit::states::{GATHER, GATHERED, PHOTON_HIT, PHOTON_NO_HIT, PHOTON_TRAV};
use crate::programs::closest_hit::streams::{
    CONTROL, GATHERED_POWER, GATHERING, HIT, PHOTON_AT, PHOTON_BOUNCE, PHOTON_CONTROL, PHOTON_DIRECTION, PHOTON_ORIGIN,
    PHOTON_POWER, PHOTON_PREVIOUS, PHOTON_RECORDS, PHOTON_STATE, PHOTON_SURFACE, PHOTON_TMAX, PREVIOUS, RAY_DIRECTION,
    RAY_ORIGIN, STATE, TMAX,
};
use crate::shared::constants::{NO_CELL, NO_TRIANGLE, RECORD};
use crate::tables::stream::Stream;

/// Layer of a record that says in which map it is.
const MAP: usize = 9;
/// The streams of a ray that a photon has of its own.
const WALK: [(Stream, Stream); 7] = [
    (STATE, PHOTON_STATE),
    (HIT, PHOTON_AT),
    (RAY_ORIGIN, PHOTON_ORIGIN),
    (RAY_DIRECTION, PHOTON_DIRECTION),
    (TMAX, PHOTON_TMAX),
    (CONTROL, PHOTON_CONTROL),
    (PREVIOUS, PHOTON_PREVIOUS),
];

/// How rays are decoded, and photons, which walk as they do.
pub(super) fn decoding() -> Decoding {
    let own = WALK.map(|(_, of_photon)| of_photon);
    let photons = Decoding {
        streams: Vec::leak([&own[..], &[PHOTON_SURFACE, PHOTON_POWER, PHOTON_BOUNCE, PHOTON_RECORDS]].concat()),
        decode: photon,
        tree: None,
        paths: None,
        ..OF_RAYS
    };
    Decoding {
        streams: Vec::leak([OF_RAYS.streams, &[GATHERING, GATHERED_POWER]].concat()),
        decode: ray,
        others: Vec::leak(vec![photons]),
        ..photons
    }
}

fn ray(texel: Texel<'_>) -> RayState {
    let ray = (OF_RAYS.decode)(texel);
    let all = texel(GATHERING).zip(texel(GATHERED_POWER)).filter(|_| matches!(ray.tag, GATHER | GATHERED));
    let gather = all.map(|(words, floats)| {
        let length = |layer: usize| f32::from_bits(floats[layer]).max(0.0).sqrt();
        Gather {
            is_caustic: words[5] == 1,
            around: Some(words[0]).filter(|&around| around != NO_CELL),
            item: words[1],
            end: words[2],
            found: words[3],
            sweep: words[4],
            visited: words[7],
            limit: length(0),
            farthest: length(3),
        }
    });
    RayState { gather, ..ray }
}

fn photon(texel: Texel<'_>) -> RayState {
    let own = |stream: Stream| WALK.iter().find(|(of_ray, _)| *of_ray == stream).and_then(|&(_, own)| texel(own));
    let ray = (OF_RAYS.decode)(&own);
    let word = |stream: Stream, layer: usize| texel(stream).and_then(|texel| texel.get(layer)).copied();
    let leaves = word(PHOTON_SURFACE, 0).filter(|&triangle| triangle != NO_TRIANGLE);
    let records = texel(PHOTON_RECORDS).unwrap_or_default().chunks_exact(RECORD as usize);
    let (mut stored, mut stored_caustic) = (0, 0);
    for (bounce, record) in (1..).zip(records) {
        match record[MAP] {
            0 => stored |= 1 << bounce,
            1 => stored_caustic |= 1 << bounce,
            _ => {}
        }
    }
    let photon = Photon {
        power: [0, 1, 2].map(|part| f32::from_bits(word(PHOTON_POWER, part).unwrap_or_default())),
        hits: word(PHOTON_BOUNCE, 0).unwrap_or_default(),
        leaves,
        stored,
        stored_caustic,
        ended: word(PHOTON_BOUNCE, 2).unwrap_or_default(),
    };
    let is_walking = matches!(ray.tag, PHOTON_TRAV | PHOTON_NO_HIT | PHOTON_HIT);
    RayState { is_walking, surface: leaves, photon: Some(photon), ..ray }
}
