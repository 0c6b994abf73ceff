//! Twin of `random.wgsl`: numbers from 0 to below 1 for the decisions of a path.
//!
//! Each pair of numbers is a point of the two-dimensional Sobol' sequence of [`samples`](crate::shared::samples), scrambled
//! by a seed of its own; so that the pairs of a path do not depend on each other, the order of the points is shuffled by a
//! seed of its own, too: padding, as in Burley, *Practical Hash-based Owen Scrambling*, JCGT 9(4), 2020, section 5.
//! Shuffling keeps aligned blocks of 2ᵏ samples together, so that each pair has one point in each of 2ᵏ equal boxes.

use crate::shared::samples::{Sampler, hashed, scrambled, sobol_second};

/// What a pair of numbers decides: which light or glowing triangle, and, in its table, whether its alias.
pub(in crate::programs) const FOR_EMITTER: u32 = 0;
/// A point of a glowing triangle.
pub(in crate::programs) const FOR_POINT: u32 = 1;
/// A direction.
pub(in crate::programs) const FOR_DIRECTION: u32 = 2;
/// Whether glass reflects, and whether the path goes on.
pub(in crate::programs) const FOR_CHANCE: u32 = 3;

/// What photons have in place of a pixel: each is a sample of one sequence.
pub(in crate::programs) const OF_PHOTONS: [u32; 2] = [u32::MAX; 2];

/// The pair of numbers by which a pixel's sample decides something at a depth. Both have 24 bits.
#[must_use]
pub(in crate::programs) fn decided_by(
    sampler: Sampler,
    seed: u32,
    [x, y]: [u32; 2],
    sample: u32,
    depth: u32,
    what: u32,
) -> [f32; 2] {
    let pair = 4 * depth + what;
    let of_pair = hashed(pair.wrapping_add(hashed(seed)));
    let seed = hashed(x.wrapping_add(hashed(y.wrapping_add(of_pair))));
    let next_seed = hashed(seed);
    let bits = match sampler {
        Sampler::Sobol => {
            let index = scrambled(sample, hashed(next_seed));
            [scrambled(index.reverse_bits(), seed), scrambled(sobol_second(index), next_seed)]
        }
        Sampler::Random => [hashed(sample.wrapping_add(seed)), hashed(hashed(sample).wrapping_add(next_seed))],
    };
    bits.map(|bits| (bits >> 8) as f32 * 5.960_464_5e-8)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_decision_has_a_net_of_its_own() {
        let pairs = |depth, what| {
            (0..256).map(move |sample| decided_by(Sampler::Sobol, 3, [7, 9], sample, depth, what)).collect::<Vec<_>>()
        };
        let boxes = |points: &[[f32; 2]], across: u32| {
            let of = |p: &[f32; 2]| [(p[0] * (1 << across) as f32) as u32, (p[1] * (256 >> across) as f32) as u32];
            points.iter().map(of).collect::<BTreeSet<_>>().len()
        };
        let first = pairs(0, FOR_EMITTER);
        for (depth, what) in [(0, FOR_EMITTER), (0, FOR_DIRECTION), (3, FOR_DIRECTION), (60, FOR_CHANCE)] {
            let points = pairs(depth, what);
            for across in 0..=8 {
                assert_eq!(boxes(&points, across), 256, "depth {depth}, {what}");
            }
            // The numbers of two decisions together fill the plane as random ones do: of 256 boxes, a share of 1/e is empty.
            if (depth, what) != (0, FOR_EMITTER) {
                let together: Vec<_> = first.iter().zip(&points).map(|(a, b)| [a[0], b[0]]).collect();
                let filled = boxes(&together, 4);
                assert!((130..=195).contains(&filled), "depth {depth}, {what}: {filled}");
            }
        }
        // Random numbers are no net.
        let random: Vec<_> = (0..256).map(|sample| decided_by(Sampler::Random, 3, [7, 9], sample, 0, 0)).collect();
        assert!(boxes(&random, 4) < 200);
    }
}
