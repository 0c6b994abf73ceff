//! What rounding may change in one pass of the program's own kernels.

use crate::program::rounding::{Off, Rounding, Ties};
use crate::programs::closest_hit::streams::{
    COLOR, HIT, PDF, PENDING, RADIANCE, RAY_DIRECTION, RAY_ORIGIN, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, STATE_T,
    THROUGHPUT,
};

/// Layers 0 to 2: x, y and z, or r, g and b.
const ALL_3: &[usize] = &[0, 1, 2];
/// A point, and what leads from it to another: some square roots, divisions and sums of terms of the scene's size.
const POINT: Off = Off::Roundings(4.0);
/// See the program `light`.
const REFRACTED: Off = Off::Roots(16.0);

/// Light by squared distances, cosines and a spot's cone.
pub(super) const OF_SAMPLE_LIGHT: Rounding = Rounding {
    floats: &[
        (RADIANCE, ALL_3, Off::RoundingsOfLight(64.0)),
        (PENDING, ALL_3, Off::RoundingsOfLight(64.0)),
        (SHADOW_ORIGIN, ALL_3, POINT),
        (SHADOW_DIRECTION, ALL_3, POINT),
        (STATE, &[STATE_T], POINT),
    ],
    ties: Ties::None,
};

/// Where paths go on, and what they carry.
pub(super) const OF_SAMPLE_BSDF: Rounding = Rounding {
    floats: &[
        (COLOR, ALL_3, Off::RoundingsOfLight(4.0)),
        (RADIANCE, ALL_3, Off::RoundingsOfLight(4.0)),
        (RAY_ORIGIN, ALL_3, POINT),
        (RAY_DIRECTION, ALL_3, REFRACTED),
        (THROUGHPUT, ALL_3, Off::Roundings(16.0)),
        (PDF, &[0], Off::Roundings(16.0)),
    ],
    ties: Ties::None,
};

/// A difference by rounding may grow from hit to hit, above all where a curved mirror or a sphere of glass spreads rays.
pub(super) const OF_FUSED_PATH: Rounding = Rounding {
    floats: &[
        (HIT, &[0, 1], Off::WeightOfTriangle),
        (STATE, &[STATE_T], Off::DistanceToTriangle),
        (COLOR, ALL_3, Off::RoundingsOfLight(4096.0)),
    ],
    ties: Ties::Many,
};
