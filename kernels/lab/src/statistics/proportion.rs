//! Proportions of rays: exact intervals, and a test of two rules on the same rays.

use statrs::function::beta::{beta_reg, inv_beta_reg};

/// What a 95% interval leaves out at each end.
const TAIL: f64 = 0.025;

/// The 95% confidence interval of a proportion, if `count` of `of` independent rays were observed (Clopper and Pearson
/// 1934). It covers the true proportion in at least 95% of all samples, whatever that proportion is, which approximations
/// do not for few counts. `None` if `of` is 0 or less than `count`.
#[must_use]
pub fn exact_interval(count: u64, of: u64) -> Option<[f64; 2]> {
    Some([lower_bound(count, of, TAIL)?, upper_bound(count, of, TAIL)?])
}

/// The proportion that is exceeded with 95% confidence at most, one-sided: 3 / `of` if none was observed.
#[must_use]
pub fn at_most(count: u64, of: u64) -> Option<f64> {
    upper_bound(count, of, 2.0 * TAIL)
}

/// The interval to report of a proportion: [exact](exact_interval); if nothing was observed, from 0 to the one-sided
/// [bound](at_most).
#[must_use]
pub fn interval_or_bound(count: u64, of: u64) -> Option<[f64; 2]> {
    if count == 0 { at_most(0, of).map(|high| [0.0, high]) } else { exact_interval(count, of) }
}

/// The smallest proportion that yields `count` or more in a share `tail` of all samples.
fn lower_bound(count: u64, of: u64, tail: f64) -> Option<f64> {
    match count {
        _ if of == 0 || count > of => None,
        0 => Some(0.0),
        _ => Some(inv_beta_reg(count as f64, (of - count + 1) as f64, tail)),
    }
}

/// The largest proportion that yields `count` or fewer in a share `tail` of all samples.
fn upper_bound(count: u64, of: u64, tail: f64) -> Option<f64> {
    match count {
        _ if of == 0 || count > of => None,
        // The general case by its closed form, which is exact where the inversion converges slowly.
        0 => Some(-(tail.ln() / of as f64).exp_m1()),
        _ if count == of => Some(1.0),
        _ => Some(inv_beta_reg((count + 1) as f64, (of - count) as f64, 1.0 - tail)),
    }
}

/// The probability of a split at least as uneven as this if two rules are equally good, where `first` rays are wrong only
/// under the first rule and `second` only under the other (McNemar 1947, exact and two-sided). Rays on which both agree
/// say nothing about it. 1 without such rays.
#[must_use]
pub fn mcnemar(first: u64, second: u64) -> f64 {
    let (few, many) = (first.min(second), first.max(second));
    if few == many {
        return 1.0;
    }
    // The binomial distribution at 1/2: the share of samples with at most `few`.
    (2.0 * beta_reg(many as f64, (few + 1) as f64, 0.5)).min(1.0)
}

/// Adjusts p-values so that rejecting those below a level is wrong at most with that probability for all of them
/// together (Holm 1979), in their order.
#[must_use]
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut adjusted = vec![1.0; p_values.len()];
    let mut least = 0.0f64;
    for (rank, &place) in order.iter().enumerate() {
        least = least.max(p_values[place] * (p_values.len() - rank) as f64).min(1.0);
        adjusted[place] = least;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Random;

    #[test]
    fn exact_intervals_are_the_published_ones() {
        // Newcombe, "Two-sided confidence intervals for the single proportion", 1998, table I, method 5.
        for (count, of, low, high) in
            [(81, 263, 0.2527, 0.3676), (15, 148, 0.0578, 0.1617), (0, 20, 0.0, 0.1684), (1, 29, 0.0009, 0.1776)]
        {
            let [l, h] = exact_interval(count, of).expect("an interval");
            assert!((l - low).abs() < 5e-5 && (h - high).abs() < 5e-5, "{count} of {of}: {l} to {h}");
        }
        // One of 32,768, in a million: R's binom.test(1, 32768).
        let [l, h] = exact_interval(1, 32_768).expect("an interval").map(|p| 1e6 * p);
        assert!((l - 0.7726).abs() < 1e-4 && (h - 170.02).abs() < 0.02, "{l} to {h}");
        assert_eq!(exact_interval(20, 20).map(|[_, high]| high), Some(1.0));
        assert_eq!((exact_interval(0, 0), exact_interval(3, 2)), (None, None));
        let none = at_most(0, 36_864).expect("a bound");
        assert!((none * 36_864.0 - 2.9957).abs() < 1e-3, "{none}");
    }

    /// The simulation: 2,000 samples of rays that are wrong with a known probability.
    #[test]
    fn exact_intervals_cover_the_truth_in_95_percent_of_samples() {
        const OF: u64 = 5_000;
        for expected in [0.1, 1.0, 2.0] {
            let truth = expected / OF as f64;
            let mut random = Random::new(7);
            let covered = (0..2_000)
                .filter(|_| {
                    let wrong = (0..OF).filter(|_| random.unit() < truth).count() as u64;
                    exact_interval(wrong, OF).is_some_and(|[low, high]| (low..=high).contains(&truth))
                })
                .count();
            println!("{expected} expected: {:.1}% covered", covered as f64 / 20.0);
            // Three standard deviations of 2,000 trials below 95% are 93.5%; exact intervals lie above 95% in truth.
            assert!(covered >= 1_900, "{expected} expected: {covered} of 2,000");
        }
    }

    #[test]
    fn pairs_are_tested_exactly_and_families_by_holm() {
        // R: binom.test(1, 8)$p.value, binom.test(0, 5), binom.test(10, 30).
        for (first, second, p) in [(1, 7, 0.0703125), (5, 0, 0.0625), (10, 20, 0.098_737_15), (4, 4, 1.0), (0, 0, 1.0)]
        {
            assert!((mcnemar(first, second) - p).abs() < 1e-7, "{first} and {second}: {}", mcnemar(first, second));
        }
        // R: p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm").
        let adjusted = holm(&[0.01, 0.04, 0.03, 0.005]);
        for (a, b) in adjusted.iter().zip([0.03, 0.06, 0.06, 0.02]) {
            assert!((a - b).abs() < 1e-12, "{adjusted:?}");
        }
    }
}
