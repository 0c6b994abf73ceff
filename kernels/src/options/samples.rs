//! Several samples per pixel: how many, and how they are distributed.
//!
//! A pixel is the square from its upper left corner to the next pixel's; every point of it has the same weight (a box
//! filter), and its colour is the mean of its samples in linear light. A single sample lies in the centre; with
//! several, none has to. A sample's position depends on its pixel, its index and the seed, not on the number of
//! samples: a run of 1,024 samples passes through the means of all shorter runs, except that of one sample.

use crate::shared::samples::Sampler;

/// The samples of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Samples {
    /// How many, from 1 to [`Samples::MOST`]; a single one is at the pixel's centre, whatever the other fields are.
    pub count: u32,
    /// How they are distributed.
    pub sampler: Sampler,
    /// Different seeds give different positions.
    pub seed: u32,
}

impl Default for Samples {
    /// One sample, in the centre.
    fn default() -> Self {
        Self { count: 1, sampler: Sampler::default(), seed: 0 }
    }
}

impl Samples {
    /// Most samples per pixel. Up to here the rounding errors of the mean stay far below the noise that remains, see
    /// [`crate::programs::closest_hit::accumulate`].
    pub const MOST: u32 = 65_536;
}
