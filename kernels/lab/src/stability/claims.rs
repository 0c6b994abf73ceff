//! Expectations about the cases: how many rays may be undecided, and where the paper's numerics must fail, each with
//! its reason.

use raystep_kernels::options::Accelerator::{self, Bvh, Grid, None};

use crate::stability::{Ceiling, Paper};

pub(super) const BY_CHANCE: Ceiling = Ceiling {
    share: 0.002,
    because: "an edge function's bound is some 20 roundings of the distance; edges are long enough for 1 ray in 1,000",
};
pub(super) const NONE: Ceiling = Ceiling { share: 0.0, because: "edge functions are exact here" };
pub(super) const AT_EDGES: Ceiling =
    Ceiling { share: 0.5, because: "either of two triangles at an edge may be the exact hit" };
pub(super) const HALF_AT_EDGES: Ceiling = Ceiling {
    share: 0.25,
    because: "half of the rays are at edges, and either of two triangles there may be the exact hit",
};
pub(super) const AT_CORNERS: Ceiling =
    Ceiling { share: 5.0 / 6.0, because: "any of six triangles around a corner may be the exact hit" };
pub(super) const fn up_to(share: f64, because: &'static str) -> Ceiling {
    Ceiling { share, because }
}

pub(super) const fn fails(fails_on: &'static [Accelerator], because: &'static str) -> Paper {
    Paper { fails_on, because }
}

pub(super) const EDGES_CRACK: Paper = fails(
    &[Grid, Bvh, None],
    "Möller-Trumbore computes an edge separately for each of its triangles, and a ray may miss both",
);
pub(super) const OUTSIDE: Paper = fails(&[Grid], "an origin outside the grid is not handled");
pub(super) const SMALL: Paper = fails(
    &[Grid, Bvh, None],
    "the determinant's threshold of 1e-6 is absolute, and these triangles' determinants are smaller",
);
