//! Several samples a pixel: how many, and how they are spread over it.
//!
//! A pixel is the square from its upper left corner to the next pixel's, every place of it counts the same (a box
//! filter), and its colour is the mean of its samples in linear light. One sample lies in the centre; of several,
//! none need to. A sample's place depends on its pixel, its number and the seed, not on how many there will be: a
//! run of 1,024 samples goes through the means of all shorter runs but that of one.

use crate::shared::samples::Sampler;

/// Samples of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Samples {
    /// How many, from 1 to [`Samples::MOST`]; 1 is the pixel's centre, whatever the rest says.
    pub count: u32,
    /// How they are spread.
    pub sampler: Sampler,
    /// Another seed, other places.
    pub seed: u32,
}

impl Default for Samples {
    /// One, in the centre.
    fn default() -> Self {
        Self { count: 1, sampler: Sampler::default(), seed: 0 }
    }
}

impl Samples {
    /// Most samples of a pixel. The mean's rounding errors stay far below what as many samples leave of noise, see
    /// [`crate::programs::closest_hit::accumulate`].
    pub const MOST: u32 = 65_536;
}
