//! Twin of `accumulate.wgsl`: adds a sample to its block's mean, and asks for the next sample.
//!
//! Samples are averaged in blocks of [`Samples::BLOCK`]. The mean of n samples of a block is the mean of n − 1, moved
//! towards the nth sample by 1/n of their difference: a pixel whose samples are all equal gets exactly their colour, and
//! the stream shows the block so far at any time. Complete blocks' means are added up in the order of their numbers, and
//! their sum is divided at the end. A sum has the same bits on every device, however it contracts products and divides:
//! so does the picture, whichever machines traced its blocks, if these have the same bits.
//!
//! Each step rounds a block's mean by at most half a unit in its last place, the sum of K means of at most m is rounded
//! by half a unit of at most K m in each of K additions, and the division adds another half: after n samples the error is
//! below (n / 16 + 13) / 2 · 2⁻²³ · m even if all errors have the same sign: 1.6e-5 m after 4,096. In practice they do
//! not: 4,096 samples of noise are off by less than 1.5e-6 m in the tests below. That many samples leave an error of about
//! 1e-3 m at an edge.

use crate::numbers::real::Real;
use crate::options::samples::Samples;
use crate::programs::closest_hit::states::{DONE, UNWRITTEN};
use crate::programs::closest_hit::streams::{
    ACCUMULATED, ACCUMULATED_SAMPLES, BLOCKS, COLOR, HIT, HIT_TRIANGLE, STATE,
};
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::tables::texels::Texels;

/// The mean of `samples` samples, from the mean of all but the last, and the last.
pub fn moved<R: Real>(mean_before: R, sample: R, samples: R) -> R {
    mean_before + (sample - mean_before) / samples
}

/// The mean of `samples` samples: of complete blocks, whose means' sum is given, and of one that is not by its share.
pub fn mean_of_blocks<R: Real>(sum: R, mean: R, samples: u32) -> R {
    let of = |count: u32| R::from_i32(count as i32);
    let (complete, part) = (of(samples / Samples::BLOCK), of(samples % Samples::BLOCK) / of(Samples::BLOCK));
    let begun = if part > R::zero() { mean * part } else { R::zero() };
    (sum + begun) / (complete + part)
}

/// Processes one ray.
pub fn accumulate<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let before: R = ray.load(ACCUMULATED, ACCUMULATED_SAMPLES);
    let wanted = R::from_i32(scene.sampling.samples as i32);
    if ray.load_u32(STATE, 0) != DONE || before >= wanted {
        return;
    }

    let has_blocks = scene.features.blocks;
    let samples = before.to_i32() as u32 + 1;
    let of_block = if has_blocks { (samples - 1) % Samples::BLOCK + 1 } else { samples };
    let is_hit = ray.load_u32(HIT, HIT_TRIANGLE) != NO_TRIANGLE;
    let coverage = if is_hit { R::one() } else { R::zero() };
    for layer in 0..4 {
        let sample = if layer < 3 { ray.load(COLOR, layer) } else { coverage };
        let mean_before = if has_blocks && of_block == 1 { R::zero() } else { ray.load(ACCUMULATED, layer) };
        let mean = moved(mean_before, sample, R::from_i32(of_block as i32));
        ray.store(ACCUMULATED, layer, mean);
        if has_blocks && of_block == Samples::BLOCK {
            ray.store(BLOCKS, layer, ray.load(BLOCKS, layer) + mean);
        }
    }
    ray.store(ACCUMULATED, ACCUMULATED_SAMPLES, R::from_i32(samples as i32));
    if samples < scene.sampling.samples {
        ray.store_u32(STATE, 0, UNWRITTEN);
        return;
    }
    for layer in 0..3 {
        let mean = ray.load(ACCUMULATED, layer);
        let all = if has_blocks { mean_of_blocks(ray.load(BLOCKS, layer), mean, samples) } else { mean };
        ray.store(COLOR, layer, all);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::samples::Sampler;

    #[test]
    fn a_mean_of_many_samples_is_off_by_little() {
        for (most, bound) in [(4096u32, 1.5e-6), (65_536, 8e-6)] {
            for pixel in 0..32 {
                let (mut mean, mut means, mut sum) = (0.0f32, 0.0f32, 0.0f64);
                for sample in 0..most {
                    let [value, _] = Sampler::Random.place([pixel, 0], sample, 1);
                    // Half of the pixels see an edge between two colours, the others noise.
                    let value = if pixel % 2 == 0 { value } else { [0.1, 0.73][usize::from(value > 0.3)] };
                    let of_block = sample % Samples::BLOCK + 1;
                    mean = moved(if of_block == 1 { 0.0 } else { mean }, value, of_block as f32);
                    means += if of_block == Samples::BLOCK { mean } else { 0.0 };
                    sum += f64::from(value);
                }
                let error = (f64::from(mean_of_blocks(means, mean, most)) - sum / f64::from(most)).abs();
                assert!(error < bound, "pixel {pixel}: {error:e} after {most}");
            }
        }
    }

    #[test]
    fn samples_of_one_colour_have_that_colour_exactly() {
        for color in [0.1f32, 0.7, 3.3e-5, 1e9] {
            let mean = (1..=10_000).fold(0.0, |mean, n| moved(mean, color, n as f32));
            assert_eq!(mean, color);
        }
    }
}
