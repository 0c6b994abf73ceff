//! Columns about light, and about the rays that kernels cast for it.

use super::{Column, count, number};

/// All of them.
pub(super) const OF_LIGHT: &[Column] = &[
    count(
        "secondary_rays",
        "rays that kernels cast from a hit to the next one in a run; empty where no light is measured",
    ),
    count("shadow_rays", "rays that kernels cast to lights in a run; empty where no light is measured"),
    number(
        "samples_per_s",
        "samples of pixels, each with a primary ray, divided by the median time; empty for other kinds of rays",
    ),
    count("undecided_shadow_rays", "rays to lights that f32 cannot decide"),
    count(
        "wrong_shadow_rays",
        "rays to lights that pass through a triangle, or are stopped where there is none or by the one that they leave",
    ),
    number("wrong_shadow_per_million", "the same per million rays to lights"),
    number(
        "light_error_median",
        "median error of a ray's light against f64, relative to its brightest channel, of rays that the same lights reach there",
    ),
    number("light_error_largest", "the largest of these errors"),
    count(
        "lit_otherwise_rays",
        "rays that other lights reach in f64, where also the rays to lights are computed in f64",
    ),
];
