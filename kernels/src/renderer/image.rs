//! The image: linear light in memory and EXR, sRGB in PNG.

use crate::numbers::srgb::linear_to_srgb;
use crate::options::samples::Samples;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::samples::mean_of_blocks;
use crate::tables::stream::StreamData;

/// A linear image, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// R G B in linear light; A is 1 if a ray hit something, else 0; with several samples, the share of rays that did.
    pub pixels: Vec<[f32; 4]>,
}

impl Image {
    pub(crate) fn from_streams(color: &StreamData, triangles: &[u32]) -> Self {
        let pixels = (0..color.width as usize * color.height as usize)
            .map(|i| {
                let alpha = if triangles[i] == NO_TRIANGLE { 0.0 } else { 1.0 };
                [color.get_f32(0, i), color.get_f32(1, i), color.get_f32(2, i), alpha]
            })
            .collect();
        Self { width: color.width, height: color.height, pixels }
    }

    /// From the mean of the latest block of samples; if there are several, from the sum of the means of those that are
    /// complete, too. `samples` is the number of samples in both.
    pub(crate) fn from_means(latest: &StreamData, blocks: Option<&StreamData>, samples: u32) -> Self {
        let pixel = |i| {
            [0, 1, 2, 3].map(|layer| {
                let mean = latest.get_f32(layer, i);
                blocks.map_or(mean, |sum| mean_of_blocks(sum.get_f32(layer, i), mean, samples))
            })
        };
        let pixels = (0..latest.width as usize * latest.height as usize).map(pixel).collect();
        Self { width: latest.width, height: latest.height, pixels }
    }

    /// R G B, 8 bits each, sRGB-encoded and clamped.
    #[must_use]
    pub fn to_srgb8(&self) -> Vec<u8> {
        let encode = |v: f32| (linear_to_srgb(v.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
        self.pixels.iter().flat_map(|p| [encode(p[0]), encode(p[1]), encode(p[2])]).collect()
    }
}

/// The mean of a picture's blocks of samples, which may have been traced elsewhere: the same bits as one run of all of
/// them on the same kind of device.
#[derive(Clone, Debug)]
pub struct Merge {
    sum: Image,
    latest: Option<Image>,
    samples: u32,
}

impl Merge {
    /// No block yet, of a picture of this size.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![[0.0; 4]; width as usize * height as usize];
        Self { sum: Image { width, height, pixels }, latest: None, samples: 0 }
    }

    /// Adds the next block, in the order of their numbers: the image of a run of [`Samples::part`]. Returns whether it
    /// did: not if the size differs, or after a block that has too few samples.
    pub fn add(&mut self, block: Image, samples: u32) -> bool {
        let is_alike = (block.width, block.height) == (self.sum.width, self.sum.height)
            && block.pixels.len() == self.sum.pixels.len();
        if !is_alike || !self.samples.is_multiple_of(Samples::BLOCK) || !(1..=Samples::BLOCK).contains(&samples) {
            return false;
        }
        if samples == Samples::BLOCK {
            for (sum, mean) in self.sum.pixels.as_flattened_mut().iter_mut().zip(block.pixels.as_flattened()) {
                *sum += mean;
            }
        }
        self.samples += samples;
        self.latest = Some(block);
        true
    }

    /// Number of samples so far.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// The mean of the blocks so far; `None` without any.
    #[must_use]
    pub fn image(&self) -> Option<Image> {
        let mut image = self.latest.clone()?;
        for (mean, sum) in image.pixels.as_flattened_mut().iter_mut().zip(self.sum.pixels.as_flattened()) {
            *mean = mean_of_blocks(*sum, *mean, self.samples);
        }
        Some(image)
    }
}
