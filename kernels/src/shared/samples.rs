//! Twin of `samples.wgsl`: the position of a sample in its pixel.
//!
//! The even sampler is the two-dimensional Sobol' sequence, a (0,2)-sequence in base 2 (Sobol' 1967; its second
//! coordinate from Pascal's triangle, as in Kollig and Keller, *Efficient Multidimensional Sampling*, 2002), with
//! Owen's nested uniform scrambling (Owen 1995) computed by a hash: Burley, *Practical Hash-based Owen Scrambling*,
//! JCGT 9(4), 2020, the source of the constants and of the Laine–Karras permutation used here. Scrambling keeps the
//! net: in each pixel every elementary box contains its point, and pixels do not repeat each other.
//!
//! The hash is PCG-RXS-M-XS (O'Neill 2014), which Jarzyński and Olano, *Hash Functions for GPU Rendering*, JCGT 9(3),
//! 2020, found the best at its cost.

use bytemuck::{Pod, Zeroable};

use crate::numbers::named::named;
use crate::numbers::real::Real;

/// How samples are distributed over a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// Evenly: each pixel has its own scrambled Sobol' sequence, in which any 2ᵏ samples that start at a multiple of 2ᵏ
    /// have one point in each of 2ᵏ equal boxes, however the pixel is divided into these. The error falls about as
    /// N^-0.75 at an edge.
    #[default]
    Sobol,
    /// Independently, for comparison. The error falls as N^-0.5.
    Random,
}

named!(Sampler, "sobol, random", Sobol "sobol", Random "random");

impl Sampler {
    /// A sample's position in its pixel, from 0 to below 1, rightwards and downwards. The same bits as in kernels.
    #[must_use]
    pub fn place(self, pixel: [u32; 2], sample: u32, seed: u32) -> [f32; 2] {
        jitter(self, pixel, sample, seed)
    }
}

/// The uniform `sampling`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Sampling {
    /// Samples per pixel.
    pub samples: u32,
    /// Different seeds give different positions.
    pub seed: u32,
    /// Index of the first sample.
    pub first: u32,
}

/// Samples that have their own mean before it is added to the pixel's.
pub const BLOCK: u32 = 16;

/// The mean of `samples` samples: of complete blocks, whose means' sum is given, and of one that is not by its share. Of
/// a single block it is `mean`, the latest block's, exactly.
pub fn mean_of_blocks<R: Real>(sum: R, mean: R, samples: u32) -> R {
    if samples <= BLOCK {
        return mean;
    }
    let of = |count: u32| R::from_i32(count as i32);
    let (complete, part) = (of(samples / BLOCK), of(samples % BLOCK) / of(BLOCK));
    let begun = if part > R::zero() { mean * part } else { R::zero() };
    (sum + begun) / (complete + part)
}

pub(crate) fn hashed(value: u32) -> u32 {
    let step = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((step >> ((step >> 28) + 4)) ^ step).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// By the Kronecker product of Pascal's triangle modulo 2: Ahmed, *An Implementation Algorithm of 2D Sobol Sequence Fast,
/// Elegant, and Compact*, 2024.
pub(crate) fn sobol_second(index: u32) -> u32 {
    let mut digits = index.reverse_bits();
    digits ^= (digits & 0x5555_5555) << 1;
    digits ^= (digits & 0x3333_3333) << 2;
    digits ^= (digits & 0x0f0f_0f0f) << 4;
    digits ^= (digits & 0x00ff_00ff) << 8;
    digits ^ (digits << 16)
}

pub(crate) fn scrambled(digits: u32, seed: u32) -> u32 {
    let mut x = digits.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// The two coordinates as fractions of 2³².
#[must_use]
pub fn sample_bits(sampler: Sampler, [x, y]: [u32; 2], sample: u32, seed: u32) -> [u32; 2] {
    let first_seed = hashed(x.wrapping_add(hashed(y.wrapping_add(hashed(seed)))));
    let second_seed = hashed(first_seed);
    match sampler {
        Sampler::Sobol => [scrambled(sample.reverse_bits(), first_seed), scrambled(sobol_second(sample), second_seed)],
        Sampler::Random => [hashed(sample.wrapping_add(first_seed)), hashed(hashed(sample).wrapping_add(second_seed))],
    }
}

/// Position from the pixel's upper left corner, both coordinates below 1: 24 bits, as many as a float holds.
#[must_use]
pub fn jitter(sampler: Sampler, pixel: [u32; 2], sample: u32, seed: u32) -> [f32; 2] {
    sample_bits(sampler, pixel, sample, seed).map(|bits| (bits >> 8) as f32 * 5.960_464_5e-8)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Whether each of the 2ᵏ boxes contains one of these 2ᵏ samples, however the pixel is divided.
    fn is_net(points: &[[u32; 2]]) -> bool {
        let k = points.len().ilog2();
        (0..=k).all(|across| {
            let digits = |value: u32, count: u32| if count == 0 { 0 } else { value >> (32 - count) };
            let boxes: BTreeSet<_> = points.iter().map(|p| [digits(p[0], across), digits(p[1], k - across)]).collect();
            boxes.len() == points.len()
        })
    }

    #[test]
    fn in_every_pixel_powers_of_two_are_a_net_and_so_are_those_that_follow() {
        for (pixel, seed) in [([0, 0], 0), ([1, 0], 0), ([511, 300], 7), ([32_767, 32_767], u32::MAX)] {
            for k in 0..=10 {
                for first in [0, 1 << k, 5 << k] {
                    let points: Vec<_> =
                        (first..first + (1 << k)).map(|n| sample_bits(Sampler::Sobol, pixel, n, seed)).collect();
                    assert!(is_net(&points), "2^{k} samples from {first} of pixel {pixel:?}");
                }
            }
        }
        // Show that the test can fail.
        let random: Vec<_> = (0..16).map(|n| sample_bits(Sampler::Random, [1, 0], n, 0)).collect();
        assert!(!is_net(&random));
    }

    /// By Pascal's triangle, column by column.
    #[test]
    fn the_second_coordinate_is_that_of_sobol() {
        let slow = |index: u32| {
            let columns = std::iter::successors(Some(0x8000_0000u32), |column| Some(column ^ (column >> 1)));
            let bits = (0..32).map(|bit| index >> bit & 1);
            bits.zip(columns).fold(0, |digits, (bit, column)| digits ^ (bit * column))
        };
        for index in (0..4096).chain((0..4096).map(hashed)) {
            assert_eq!(sobol_second(index), slow(index), "{index}");
        }
    }

    #[test]
    fn every_sample_is_somewhere_else_in_every_pixel_and_for_every_seed() {
        for &sampler in Sampler::ALL {
            let places: BTreeSet<_> = (0..64)
                .flat_map(|x| (0..64).map(move |y| [x, y]))
                .flat_map(|pixel| [0, 1].map(|seed| sample_bits(sampler, pixel, 0, seed)))
                .collect();
            assert_eq!(places.len(), 2 * 64 * 64, "{sampler}");
            let samples: BTreeSet<_> = (0..65_536).map(|n| sample_bits(sampler, [3, 5], n, 0)).collect();
            assert_eq!(samples.len(), 65_536, "{sampler}");
        }
    }

    #[test]
    fn places_are_exact_and_within_the_pixel() {
        for &sampler in Sampler::ALL {
            for n in 0..4096 {
                let (bits, place) = (sample_bits(sampler, [9, 4], n, 1), jitter(sampler, [9, 4], n, 1));
                for (bits, place) in bits.into_iter().zip(place) {
                    assert_eq!(f64::from(place), f64::from(bits >> 8) / (1u32 << 24) as f64);
                    assert!((0.0..1.0).contains(&place));
                }
            }
        }
    }

    /// The part of a unit square below the line with this slope through the point (x, y), exact in f64.
    fn coverage(x: f64, y: f64, slope: f64) -> f64 {
        // The integral from 0 to 1 of the line, clamped to the square: trapezoids between the points where clamping
        // begins.
        let height = |at: f64| (y + slope * (at - x)).clamp(0.0, 1.0);
        let mut cuts = vec![0.0, x + (0.0 - y) / slope, x + (1.0 - y) / slope, 1.0];
        cuts.retain(|c| (0.0..=1.0).contains(c));
        cuts.sort_by(f64::total_cmp);
        cuts.windows(2).map(|w| (w[1] - w[0]) * (height(w[0]) + height(w[1])) / 2.0).sum()
    }

    /// Root mean square, over pixels with an edge each, of the error of their coverage.
    fn edge_rmse(sampler: Sampler, samples: u32) -> f64 {
        let pixels = 600;
        let square = |i: u32| {
            // Through the inside of the pixel, at any angle except along an axis.
            let at = |n: u32| f64::from(n) * 0.618_033_988_749_895 % 1.0;
            let (x, y, slope) = (at(i + 1), at(3 * i + 2), (0.1 + 1.4 * at(7 * i + 1)).tan());
            let is_below = |n: &u32| {
                let [px, py] = sampler.place([i, 17], *n, 0).map(f64::from);
                py < y + slope * (px - x)
            };
            let counted = (0..samples).filter(is_below).count() as f64 / f64::from(samples);
            (counted - coverage(x, y, slope)).powi(2)
        };
        ((0..pixels).map(square).sum::<f64>() / f64::from(pixels)).sqrt()
    }

    /// In theory, at an edge that cuts √N of a net's N boxes, the error is N^-3/4; of independent samples, N^-1/2.
    #[test]
    fn the_error_at_an_edge_falls_as_theory_says() {
        for (sampler, expected) in [(Sampler::Sobol, -0.75), (Sampler::Random, -0.5)] {
            let errors: Vec<_> = (2..=10).map(|k| (f64::from(k), edge_rmse(sampler, 1 << k).log2())).collect();
            let mean = |f: fn(&(f64, f64)) -> f64| errors.iter().map(f).sum::<f64>() / errors.len() as f64;
            let (mean_k, mean_error) = (mean(|e| e.0), mean(|e| e.1));
            let cross: f64 = errors.iter().map(|e| (e.0 - mean_k) * (e.1 - mean_error)).sum();
            let slope = cross / errors.iter().map(|e| (e.0 - mean_k).powi(2)).sum::<f64>();
            println!("{sampler}: slope {slope:.3}, RMSE 2^{:.2} of 1024 samples", errors[8].1);
            // With 600 pixels an RMSE is known to 3%: 0.04 in its logarithm, against 8 in that of N.
            assert!((slope - expected).abs() < 0.03, "{sampler}: {slope}");
        }
    }
}
