//! What rounding may change in one pass of the program's own kernels.

use crate::options::MOST_DEPTH;
use crate::program::rounding::{Off, Rounding, Ties};
use crate::programs::closest_hit::streams::{
    COLOR, GATHERED_POWER, PDF, PHOTON_DIRECTION, PHOTON_ENERGY, PHOTON_ORIGIN, PHOTON_POWER, PHOTON_RECORDS, RADIANCE,
    RAY_DIRECTION, RAY_ORIGIN, SHRUNK, THROUGHPUT,
};
use crate::shared::constants::RECORD;

/// Layers 0 to 2: x, y and z, or r, g and b.
const ALL_3: &[usize] = &[0, 1, 2];
/// A point, and what leads from it to another: some square roots, divisions and sums of terms of the scene's size.
const POINT: Off = Off::Roundings(4.0);
/// See the program `light`.
const REFRACTED: Off = Off::Roots(16.0);
/// All of a photon's energy.
const ENERGY: &[usize] = &[0, 1, 2, 3, 4, 5, 6, 7, 8];

/// The floats of each record.
const RECORDED: &[usize] = &{
    let mut layers = [0; 9 * (MOST_DEPTH - 1) as usize];
    let mut i = 0;
    while i < layers.len() {
        layers[i] = i / 9 * RECORD as usize + i % 9;
        i += 1;
    }
    layers
};

/// Points of emitters, directions, and what photons carry.
pub(super) const OF_EMIT_PHOTONS: Rounding = Rounding {
    floats: &[
        (PHOTON_ORIGIN, ALL_3, POINT),
        (PHOTON_DIRECTION, ALL_3, Off::Roundings(16.0)),
        (PHOTON_POWER, ALL_3, Off::RoundingsOfLight(64.0)),
        (PHOTON_ENERGY, ENERGY, Off::RoundingsOfLight(64.0)),
    ],
    ties: Ties::None,
};

/// Where photons arrive and go on, and what becomes of what they carry.
pub(super) const OF_SCATTER_PHOTONS: Rounding = Rounding {
    floats: &[
        (PHOTON_ORIGIN, ALL_3, POINT),
        (PHOTON_DIRECTION, ALL_3, REFRACTED),
        (PHOTON_POWER, ALL_3, Off::Roundings(16.0)),
        (PHOTON_ENERGY, ENERGY, Off::Roundings(16.0)),
        (PHOTON_RECORDS, RECORDED, Off::Roundings(16.0)),
    ],
    ties: Ties::None,
};

/// The density of photons, and where rays go on.
pub(super) const OF_LOOK_UP: Rounding = Rounding {
    floats: &[
        (COLOR, ALL_3, Off::RoundingsOfLight(64.0)),
        (RADIANCE, ALL_3, Off::RoundingsOfLight(64.0)),
        (SHRUNK, &[0, 1, 2, 3, 4, 5, 6, 7], Off::Roundings(4.0)),
        (RAY_ORIGIN, ALL_3, POINT),
        (RAY_DIRECTION, ALL_3, REFRACTED),
        (THROUGHPUT, ALL_3, Off::Roundings(16.0)),
        (PDF, &[0], Off::Roundings(16.0)),
    ],
    ties: Ties::None,
};

/// Distances of cells and photons, with which others are compared, and sums over many photons.
pub(super) const OF_GATHER: Rounding = Rounding {
    floats: &[(GATHERED_POWER, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], Off::RoundingsOfLight(256.0))],
    ties: Ties::Many,
};
