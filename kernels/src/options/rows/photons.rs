//! The options of photon maps.

use std::fmt;

use super::{Refusal, Row, Values, parse, text};
use crate::options::row::{Value, whole};
use crate::options::{Choices, Gather as Place, Integrator, Neighbours, PhotonSort, Photons, ProgramName};

pub(super) fn has_photons(c: &Choices) -> bool {
    c.program == ProgramName::ClosestHit && c.integrator == Integrator::Photons
}

/// An option of photons, where there are none.
fn idle(option: &str, value: impl fmt::Display, is_default: bool, c: &Choices) -> Option<Refusal> {
    let why = || format!("{option} {value} applies to --integrator photons, not to {}: omit it", c.integrator);
    (!is_default && !has_photons(c)).then(|| Refusal::Idle(why()))
}

/// The row of an option of photons that is an integer.
macro_rules! whole {
    ($name:literal, $most:expr, $field:ident, $help:literal) => {
        Row::new(
            $name,
            Values::Whole(1, $most),
            |c| Value::Number(c.photons.$field),
            |c, value| whole(value, 1, $most).map(|number| c.photons.$field = number),
            $help,
        )
        .applies(has_photons)
        .refused(|c| idle(concat!("--", $name), c.photons.$field, c.photons.$field == Photons::default().$field, c))
    };
}

pub(super) const PHOTONS: Row = whole!(
    "photons",
    Photons::MOST,
    count,
    "How many photons are emitted, with --integrator photons; rounded up to whole rows of a texture"
)
.panel("photons", "how many photons are emitted");

pub(super) const SORT: Row = Row::new(
    "photon-map",
    Values::Names(|| PhotonSort::ALL.iter().map(|of| of.name()).collect()),
    |c| text(c.photons.sort),
    |c, value| parse(value, &mut c.photons.sort),
    "How photons are sorted by the cells of their map, with --integrator photons: by a bitonic sort, as in the paper of \
     Purcell et al. (bitonic), or by a radix sort, which takes fewer passes (scan). The map is the same",
)
.panel("photon map", "how photons are sorted by the cells of their map")
.applies(has_photons)
.refused(|c| idle("--photon-map", c.photons.sort, c.photons.sort == PhotonSort::default(), c));

pub(super) const NEIGHBOURS: Row = Row::new(
    "neighbours",
    Values::Names(|| Neighbours::ALL.iter().map(|of| of.name()).collect()),
    |c| text(c.photons.neighbours),
    |c, value| parse(value, &mut c.photons.neighbours),
    "Which photons the light at a point is estimated from, with --integrator photons: all within the distance at which \
     --nearest were found, cell by cell, as in the paper of Purcell et al. (knn-grid), or exactly the nearest (exact)",
)
.panel("neighbours", "which photons the light at a point is estimated from")
.applies(has_photons)
.refused(|c| idle("--neighbours", c.photons.neighbours, c.photons.neighbours == Neighbours::default(), c));

pub(super) const GATHER: Row = Row::new(
    "gather",
    Values::Names(|| Place::ALL.iter().map(|of| of.name()).collect()),
    |c| text(c.photons.gather),
    |c, value| parse(value, &mut c.photons.gather),
    "Where photons are looked up, with --integrator photons: at the surface that is seen (direct); or there for caustics \
     alone, and for all other light where a ray from there arrives, which turns blotches into noise (final)",
)
.panel("gather", "where photons are looked up: at the surface that is seen, or where a ray from there arrives")
.applies(has_photons)
.refused(|c| idle("--gather", c.photons.gather, c.photons.gather == Place::default(), c));

pub(super) const NEAREST: Row = whole!(
    "nearest",
    Photons::MOST_NEAREST,
    nearest,
    "How many photons the light at a point is estimated from, with --integrator photons, if so many are near enough"
)
.panel("nearest photons", "how many photons the light at a point is estimated from");

pub(super) const RADIUS: Row = whole!(
    "gather-radius",
    Photons::MOST_RADIUS,
    radius,
    "How near photons must be to count at a point, with --integrator photons, in thousandths of the diagonal of the \
     scene's box"
)
.panel("radius", "how near photons must be to count at a point, in thousandths of the scene's diagonal");
