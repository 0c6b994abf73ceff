//! Several samples per pixel: how many, and how they are distributed.
//!
//! A pixel is the square from its upper left corner to the next pixel's; every point of it has the same weight (a box
//! filter), and its colour is the mean of its samples in linear light. A single sample lies in the centre; with
//! several, none has to. A sample's position depends on its pixel, its index and the seed, not on the number of
//! samples: a run of 1,024 samples passes through the means of all shorter runs, except that of one sample.
//!
//! Samples are averaged in blocks of [`Samples::BLOCK`], each with its own mean, and the blocks in the order of their
//! numbers. So the blocks of one picture can be traced by different machines: [`Samples::part`] is the run of one block,
//! and [`Merge`](crate::renderer::image::Merge) gives their means' mean, in the same bits as one run of all of them.

use crate::shared::samples::{BLOCK, Sampler};

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
    /// Index of the first: other than 0 for a part of a picture.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub first: u32,
}

impl Default for Samples {
    /// One sample, in the centre.
    fn default() -> Self {
        Self { count: 1, sampler: Sampler::default(), seed: 0, first: 0 }
    }
}

impl Samples {
    /// Most samples per pixel. Up to here the rounding errors of the mean stay far below the noise that remains, see
    /// [`crate::programs::closest_hit::accumulate`].
    pub const MOST: u32 = 65_536;
    /// Samples that have their own mean before it is added to the pixel's.
    pub const BLOCK: u32 = BLOCK;

    /// Whether the rays of a pixel are distributed over it: not for a single sample, in the centre.
    #[must_use]
    pub fn are_spread(&self) -> bool {
        self.count > 1 || self.first > 0
    }

    /// Number of blocks; the last may have fewer samples.
    #[must_use]
    pub fn blocks(&self) -> u32 {
        self.count.div_ceil(Self::BLOCK)
    }

    /// One block, counted from 0: none after the last.
    #[must_use]
    pub fn part(&self, block: u32) -> Option<Self> {
        let before = block.checked_mul(Self::BLOCK).filter(|&before| before < self.count)?;
        let count = (self.count - before).min(Self::BLOCK);
        Some(Self { first: self.first.checked_add(before)?, count, ..*self })
    }
}
