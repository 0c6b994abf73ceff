//! The options of samples: how many a pixel has, and how they and photons are distributed.

use super::photons::has_photons;
use super::{Refusal, Row, Value, Values, impossible, parse, text, whole};
use crate::options::Choices;
use crate::options::mapping::{Mapping, ONE_SAMPLE};
use crate::options::samples::Samples;
use crate::shared::samples::Sampler;

pub(super) const SPP: Row = whole!(
    "spp",
    1,
    Samples::MOST,
    samples.count,
    "Samples per pixel, averaged. 1 samples the pixel's centre; with more, all streams except color and accumulated \
     belong to the last sample. With --integrator photons, each is an iteration, which emits new photons and looks for \
     them within a smaller radius"
)
.alias("iterations")
.refused(|c| (c.samples.are_spread() && c.mapping != Mapping::Compute).then(|| impossible(ONE_SAMPLE)));

pub(super) const SAMPLER: Row = named!(
    "sampler",
    Sampler,
    samples.sampler,
    "Distribution of samples in a pixel: even, by a scrambled Sobol' sequence (sobol), or independent (random)"
)
.in_tables(Some(|c| if is_sampled(c) { text(c.samples.sampler) } else { Value::Nothing }))
.refused(|c| if c.samples.sampler == Sampler::Random { idle_for_one_sample("--sampler random", c) } else { None });

pub(super) const SEED: Row =
    whole!("seed", 0, u32::MAX, samples.seed, "Seed of the samples; the same seed gives the same image")
        .in_tables(Some(|c| if is_sampled(c) { Value::Number(c.samples.seed) } else { Value::Nothing }))
        .refused(|c| if c.samples.seed != 0 { idle_for_one_sample("--seed", c) } else { None });

/// Whether anything is distributed: samples of pixels, or photons.
fn is_sampled(c: &Choices) -> bool {
    c.samples.count > 1 || has_photons(c)
}

fn idle_for_one_sample(option: &str, c: &Choices) -> Option<Refusal> {
    let why = || format!("{option} requires several samples per pixel: omit it, or add --spp N");
    (!is_sampled(c)).then(why).map(Refusal::Idle)
}
