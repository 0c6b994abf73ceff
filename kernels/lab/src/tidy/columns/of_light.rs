//! Columns about light, and about the rays that kernels cast for it.

use super::{Column, count, number, text};

/// All of them.
pub(super) const OF_LIGHT: &[Column] = &[
    count(
        "secondary_rays",
        "rays that kernels cast from a hit to the next one in a run, and those of photons; empty where no light is measured",
    ),
    text(
        "integrator_options",
        "options of the light that is measured, such as max_depth=5 strategy=mis; empty without any",
    ),
    count("shadow_rays", "rays that kernels cast to lights in a run; empty where no light is measured"),
    number(
        "samples_per_s",
        "samples of pixels, each with a primary ray, divided by the median time; empty for other kinds of rays",
    ),
    text("path_strategy", "how paths find light: mis, light or bsdf"),
    count("max_depth", "most bounces of a path or photon"),
    text("estimator", "how light is estimated: path, or photons and how they are gathered (direct or final)"),
    count("photons_emitted", "photons that are emitted for each sample; empty without photons"),
    number(
        "bias_squared",
        "mean over pixels of the squared difference between the reference and the mean of infinitely many seeds: an estimate, \
         which may be below 0",
    ),
    number("bias_squared_low", "lower end of its interval, by the jackknife over seeds"),
    number("bias_squared_high", "upper end of its interval, by the jackknife over seeds"),
    number("variance", "mean over pixels of the variance of one seed's image"),
    number("ns_per_sample", "median time of a run divided by its samples per pixel"),
    number("image_ns", "samples times ns_per_sample"),
    number("flip", "mean of FLIP over all pixels, from 0 to 1; of a seed, or the median over seeds"),
    number("flip_low", "lower end of the interval of the median"),
    number("flip_high", "upper end of the interval of the median"),
    number(
        "same_error_time_ratio",
        "time for the same error, to that by strategy mis with the same structure: the ratio of squared errors at the same number \
         of samples and seeds, times that of the times of a sample; empty unless is_fitted",
    ),
    number("same_error_time_ratio_low", "lower end of it, by the intervals of both ratios"),
    number("same_error_time_ratio_high", "upper end of it, by the intervals of both ratios"),
    count("undecided_shadow_rays", "rays to lights that f32 cannot decide"),
    count(
        "wrong_shadow_rays",
        "rays to lights that pass through a triangle, or are stopped where there is none or by the one that they leave",
    ),
    number("wrong_shadow_per_million", "the same per million rays to lights"),
    count(
        "close_shadow_starts",
        "rays to lights that begin so near to another surface that rounding may have put their start on its other side",
    ),
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
