//! Intervals of medians, and of ratios of times that were measured in pairs.

use raystep_kernels::named;
use statrs::function::beta::beta_reg;

use super::{median, quantile};
use crate::rays::Random;

/// How an interval was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Two of the sorted values, which enclose the true median with a probability that follows from their ranks alone
    /// (Thompson 1936).
    OrderStatistics,
    /// The middle 95% of the medians of samples drawn from the values (Efron 1979).
    Bootstrap,
}

named!(Method, OrderStatistics "order_statistics", Bootstrap "bootstrap");

/// A confidence interval of a median.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The median.
    pub median: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// The probability of covering the true median, 0.95 or somewhat more.
    pub level: f64,
    /// How it was found.
    pub method: Method,
}

impl Interval {
    /// Whether it contains a value: whether what was measured cannot be distinguished from it.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// Fewest values for an interval: of five, not even the smallest and the largest enclose the median in 95% of cases.
pub const FEWEST: usize = 6;
/// Fewest values for a bootstrap.
const FEWEST_FOR_BOOTSTRAP: usize = 20;
/// Samples drawn from the values.
const RESAMPLES: usize = 2_000;

/// The interval of the median of independent values; `None` for fewer than [`FEWEST`]. NaN is not a value.
#[must_use]
pub fn of_median(values: &[f64], seed: u64) -> Option<Interval> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    match sorted.len() {
        n if n < FEWEST => None,
        n if n < FEWEST_FOR_BOOTSTRAP => by_order(&sorted),
        _ => bootstrap(&sorted, seed),
    }
}

/// The interval of the median ratio of pairs (a, b) that were measured one beside the other: a / b. Pairs that are not
/// above 0 are left out.
#[must_use]
pub fn of_ratio(pairs: &[(f64, f64)], seed: u64) -> Option<Interval> {
    let logarithms: Vec<f64> = pairs.iter().filter(|(a, b)| *a > 0.0 && *b > 0.0).map(|(a, b)| (a / b).ln()).collect();
    let interval = of_median(&logarithms, seed)?;
    let [median, low, high] = [interval.median, interval.low, interval.high].map(f64::exp);
    Some(Interval { median, low, high, ..interval })
}

/// The narrowest pair of values, as far from either end, that encloses the median with 95% or more.
fn by_order(sorted: &[f64]) -> Option<Interval> {
    let n = sorted.len();
    // Both ends miss if fewer than `rank` of n values lie on one side of the true median.
    let level = |rank: usize| 1.0 - 2.0 * beta_reg((n - rank + 1) as f64, rank as f64, 0.5);
    let rank = (1..=n / 2).rev().find(|&rank| level(rank) >= 0.95)?;
    Some(Interval {
        median: median(sorted)?,
        low: sorted[rank - 1],
        high: sorted[n - rank],
        level: level(rank),
        method: Method::OrderStatistics,
    })
}

fn bootstrap(sorted: &[f64], seed: u64) -> Option<Interval> {
    let mut random = Random::new(seed);
    let mut drawn = vec![0.0; sorted.len()];
    let mut medians = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        drawn.fill_with(|| sorted[random.below(sorted.len())]);
        medians.push(median(&drawn)?);
    }
    let [low, high] = [quantile(&medians, 0.025)?, quantile(&medians, 0.975)?];
    Some(Interval { median: median(sorted)?, low, high, level: 0.95, method: Method::Bootstrap })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times as a busy machine gives them: most near 1, a tail above. Their median is 1.
    fn time(random: &mut Random) -> f64 {
        let spread = random.unit() - 0.5;
        if spread < 0.0 { 1.0 + 0.1 * spread } else { 1.0 + 0.1 * spread / (0.55 - spread) }
    }

    /// How many of 2,000 intervals of n such times cover the true median.
    fn covered(n: usize) -> usize {
        let mut random = Random::new(11);
        (0..2_000)
            .filter(|&trial| {
                let times: Vec<f64> = (0..n).map(|_| time(&mut random)).collect();
                of_median(&times, trial).is_some_and(|interval| interval.contains(1.0))
            })
            .count()
    }

    #[test]
    fn bootstrapped_intervals_cover_the_median_as_often_as_they_say() {
        for n in [20, 30, 50] {
            let share = covered(n) as f64 / 2_000.0;
            println!("bootstrap, {n} values: {:.1}%", 100.0 * share);
            assert!((0.93..=0.97).contains(&share), "{n} values: {share}");
        }
    }

    #[test]
    fn order_statistics_cover_the_median_at_their_true_level() {
        for n in [6, 9, 12, 19] {
            let level = by_order(&vec![1.0; n]).expect("an interval").level;
            let share = covered(n) as f64 / 2_000.0;
            // Three standard deviations of a share of 2,000 at 0.95.
            assert!((share - level).abs() < 0.0147, "{n} values: {share}, not {level}");
        }
        // 1 - 2 / 2⁶; of nine values the second and the eighth: 1 - 2 (1 + 9) / 2⁹.
        let of = |n: u32| of_median(&(0..n).map(f64::from).collect::<Vec<_>>(), 0);
        for (n, low, high, level) in [(6, 0.0, 5.0, 0.96875), (9, 1.0, 7.0, 0.9609375)] {
            let interval = of(n).expect("an interval");
            assert_eq!((interval.low, interval.high), (low, high), "{n} values");
            assert!((interval.level - level).abs() < 1e-12, "{interval:?}");
        }
        assert_eq!(of(5), None);
    }

    #[test]
    fn ratios_are_of_pairs_whatever_both_took() {
        let mut random = Random::new(3);
        // Each pair is as slow as its moment; the second takes 1.2 times as long, give or take 2%.
        let pairs: Vec<(f64, f64)> = (0..25)
            .map(|_| {
                let slow = 1.0 + 3.0 * random.unit();
                (1.2 * slow * (0.98 + 0.04 * random.unit()), slow)
            })
            .collect();
        let ratio = of_ratio(&pairs, 1).expect("an interval");
        assert!(ratio.contains(1.2) && !ratio.contains(1.0) && ratio.high - ratio.low < 0.03, "{ratio:?}");
        assert_eq!(of_ratio(&pairs, 1), Some(ratio));
        assert_eq!(of_ratio(&[(1.0, 0.0); 20], 1), None);
    }
}
