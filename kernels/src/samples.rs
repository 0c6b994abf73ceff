//! Several samples a pixel: how many, and how they are spread over it.
//!
//! A pixel is the square from its upper left corner to the next pixel's, every place of it counts the same (a box
//! filter), and its colour is the mean of its samples in linear light. One sample lies in the centre; of several,
//! none need to. A sample's place depends on its pixel, its number and the seed, not on how many there will be: a
//! run of 1,024 samples goes through the means of all shorter runs but that of one.

use serde::{Deserialize, Serialize};

use crate::options::named;
use crate::shared::samples::jitter;

/// How samples are spread over a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// Evenly: each pixel has a scrambled Sobol' sequence of its own, any 2ᵏ of which from a multiple of 2ᵏ on have
    /// one point in each of 2ᵏ equal boxes, however these are cut. The error falls about as N^-0.75 at an edge.
    #[default]
    Sobol,
    /// Independently, as measure of the other. The error falls as N^-0.5.
    Random,
}

named!(Sampler, "sobol, random", Sobol "sobol", Random "random");

impl Sampler {
    /// Where in its pixel, from 0 to below 1 rightwards and downwards, a sample lies. The same bits as in kernels.
    #[must_use]
    pub fn place(self, pixel: [u32; 2], sample: u32, seed: u32) -> [f32; 2] {
        jitter(self, pixel, sample, seed)
    }
}

/// Samples of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
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
    /// [`crate::accumulate`].
    pub const MOST: u32 = 65_536;
}
