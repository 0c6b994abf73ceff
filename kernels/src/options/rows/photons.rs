//! The options of photon maps.

use std::fmt;

use super::{Refusal, Row, Value, Values, parse, text, whole};
use crate::options::{Choices, Gather as Place, Integrator, Neighbours, PhotonSort, Photons, ProgramName};

pub(super) fn has_photons(c: &Choices) -> bool {
    c.program == ProgramName::ClosestHit && c.integrator == Integrator::Photons
}

/// An option of photons, where there are none.
fn idle(option: &str, value: impl fmt::Display, is_default: bool, c: &Choices) -> Option<Refusal> {
    let why = || format!("{option} {value} applies to --integrator photons, not to {}: omit it", c.integrator);
    (!is_default && !has_photons(c)).then(|| Refusal::Idle(why()))
}

/// A row that applies only where there are photons.
macro_rules! of_photons {
    ($name:literal, $field:ident, $row:expr) => {
        $row.applies(has_photons)
            .refused(|c| idle(concat!("--", $name), c.photons.$field, c.photons.$field == Photons::default().$field, c))
    };
}

macro_rules! number {
    ($name:literal, $most:expr, $field:ident, $help:literal) => {
        of_photons!($name, $field, whole!($name, 1, $most, photons.$field, $help))
    };
}

macro_rules! choice {
    ($name:literal, $type:ident, $field:ident, $help:literal) => {
        of_photons!($name, $field, named!($name, $type, photons.$field, $help))
    };
}

pub(super) const PHOTONS: Row = number!(
    "photons",
    Photons::MOST,
    count,
    "How many photons are emitted, with --integrator photons; rounded up to whole rows of a texture"
)
.panel("photons", "how many photons are emitted");

pub(super) const SORT: Row = choice!(
    "photon-map",
    PhotonSort,
    sort,
    "How photons are sorted by the cells of their map, with --integrator photons: by a bitonic sort, as in the paper of \
     Purcell et al. (bitonic), or by a radix sort, which takes fewer passes (scan). The map is the same"
)
.panel("photon map", "how photons are sorted by the cells of their map");

pub(super) const NEIGHBOURS: Row = choice!(
    "neighbours",
    Neighbours,
    neighbours,
    "Which photons the light at a point is estimated from, with --integrator photons: all within the distance at which \
     --nearest were found, cell by cell, as in the paper of Purcell et al. (knn-grid), or exactly the nearest (exact)"
)
.panel("neighbours", "which photons the light at a point is estimated from");

pub(super) const GATHER: Row = choice!(
    "gather",
    Place,
    gather,
    "Where photons are looked up, with --integrator photons: at the surface that is seen (direct); or there for caustics \
     alone, and for all other light where a ray from there arrives, which turns blotches into noise (final)"
)
.panel("gather", "where photons are looked up: at the surface that is seen, or where a ray from there arrives");

pub(super) const NEAREST: Row = number!(
    "nearest",
    Photons::MOST_NEAREST,
    nearest,
    "How many photons the light at a point is estimated from, with --integrator photons, if so many are near enough"
)
.panel("nearest photons", "how many photons the light at a point is estimated from");

pub(super) const RADIUS: Row = number!(
    "gather-radius",
    Photons::MOST_RADIUS,
    radius,
    "How near photons must be to count at a point, with --integrator photons, in thousandths of the diagonal of the \
     scene's box"
)
.panel("radius", "how near photons must be to count at a point, in thousandths of the scene's diagonal");
