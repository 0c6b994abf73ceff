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

    /// Number of rays that hit something, of so many samples of every pixel.
    ///
    /// A pixel's A is a mean of zeros and ones, so it is a multiple of 1/samples but for rounding. That is below half of
    /// it for as many samples as there may be: sums of means that are large are exact again, since all of these are
    /// multiples of 1/16.
    #[must_use]
    pub fn hits(&self, samples: u32) -> u64 {
        self.pixels.iter().map(|pixel| (f64::from(pixel[3]) * f64::from(samples)).round() as u64).sum()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::programs::closest_hit::accumulate::moved;
    use crate::shared::samples::Sampler;

    /// The share of hits as the kernel `accumulate` keeps it, of samples each of which hits or misses.
    fn share(hits: impl Iterator<Item = bool>) -> (f32, u32, u64) {
        let (mut mean, mut means, mut samples, mut sum) = (0.0f32, 0.0f32, 0, 0);
        for hit in hits {
            let of_block = samples % Samples::BLOCK + 1;
            mean = moved(if of_block == 1 { 0.0 } else { mean }, f32::from(u8::from(hit)), of_block as f32);
            means += if of_block == Samples::BLOCK { mean } else { 0.0 };
            samples += 1;
            sum += u64::from(hit);
        }
        (mean_of_blocks(means, mean, samples), samples, sum)
    }

    #[test]
    fn hits_of_all_samples_are_counted_exactly() {
        for samples in [1, 2, 3, 7, 15, 16, 17, 100, 4095, 4096, 65_521, Samples::MOST] {
            for pixel in 0..40 {
                let rate = [0.5, 0.02, 0.98, 1.0 / 3.0][pixel as usize % 4];
                let value = |sample| Sampler::Random.place([pixel, 3], sample, 1)[0];
                let (alpha, samples, sum) = share((0..samples).map(|sample| value(sample) < rate));
                let image = Image { width: 1, height: 1, pixels: vec![[0.0, 0.0, 0.0, alpha]] };
                assert_eq!(image.hits(samples), sum, "{samples} samples, pixel {pixel}");
            }
        }
    }
}
