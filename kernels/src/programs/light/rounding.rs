//! What rounding may change in one pass of the program's own kernels.

use crate::options::MOST_DEPTH;
use crate::program::rounding::{Off, Rounding, Ties};
use crate::programs::closest_hit::streams::{
    BRANCHES, COLOR, PENDING, RADIANCE, RAY_DIRECTION, RAY_ORIGIN, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, STATE_T,
    THROUGHPUT,
};
use crate::shared::constants::BRANCH;

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

/// A refracted direction, and what Fresnel's equations give: the square of the cosine of the refracted ray is the difference
/// of 1 and a product of six factors, and its root is a root's worth off where it is near 0.
const REFRACTED: Off = Off::Roots(16.0);

/// Layers of what waits at each depth: origins, and the rest.
const BRANCH_ORIGINS: &[usize] = &branch_layers::<24>(0);
const BRANCH_OTHERS: &[usize] = &branch_layers::<48>(3);

const fn branch_layers<const N: usize>(first: usize) -> [usize; N] {
    let mut layers = [0; N];
    let of_each = N / MOST_DEPTH as usize;
    let mut i = 0;
    while i < N {
        layers[i] = i / of_each * BRANCH as usize + first + i % of_each;
        i += 1;
    }
    layers
}

/// Where rays begin that go on from a hit, and where they lead.
pub(super) const OF_SCATTER: Rounding = Rounding {
    floats: &[
        (COLOR, ALL_3, Off::RoundingsOfLight(4.0)),
        (RADIANCE, ALL_3, Off::RoundingsOfLight(4.0)),
        (RAY_ORIGIN, ALL_3, POINT),
        (RAY_DIRECTION, ALL_3, REFRACTED),
        (THROUGHPUT, ALL_3, REFRACTED),
        (BRANCHES, BRANCH_ORIGINS, POINT),
        (BRANCHES, BRANCH_OTHERS, REFRACTED),
    ],
    ties: Ties::None,
};
