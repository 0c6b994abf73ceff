//! What rounding may change in one pass of the program's own kernel.

use crate::program::rounding::{Off, Rounding, Ties};
use crate::programs::closest_hit::streams::{COLOR, PENDING, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, STATE_T};

/// Layers 0 to 2: x, y and z, or r, g and b.
const ALL_3: &[usize] = &[0, 1, 2];
/// A point, and what leads from it to a light: some square roots, divisions and sums of terms of the scene's size.
const POINT: Off = Off::Roundings(4.0);

/// Light as in `shade`; where rays begin, lead to and end.
pub(super) const OF_ILLUMINATE: Rounding = Rounding {
    floats: &[
        (COLOR, ALL_3, Off::RoundingsOfLight(64.0)),
        (PENDING, ALL_3, Off::RoundingsOfLight(64.0)),
        (SHADOW_ORIGIN, ALL_3, POINT),
        (SHADOW_DIRECTION, ALL_3, POINT),
        (STATE, &[STATE_T], POINT),
    ],
    ties: Ties::None,
};
