//! The sign test of a median, and the bounds that follow from it: exact for independent values of any distribution,
//! since each lies above the true median with probability 1/2 (Arbuthnott 1710; Thompson 1936 for the bounds).

use statrs::distribution::{ContinuousCDF as _, Normal};
use statrs::function::beta::beta_reg;

use super::median;

/// The probability that `count` or more of `of` independent values lie above their median. 1 if `count` is 0.
#[must_use]
pub fn p_above(count: usize, of: usize) -> f64 {
    match count {
        0 => 1.0,
        _ if count > of => 0.0,
        // The upper tail of the binomial distribution at 1/2.
        _ => beta_reg(count as f64, (of - count + 1) as f64, 0.5),
    }
}

/// The p-values of two hypotheses on the median of `values`: that it is at most `limit`, and that it is at least that.
#[must_use]
pub fn p_values(values: &[f64], limit: f64) -> [f64; 2] {
    let above = values.iter().filter(|&&v| v > limit).count();
    let below = values.iter().filter(|&&v| v < limit).count();
    [p_above(above, values.len()), p_above(below, values.len())]
}

/// A value that lies above the true median with probability `tail` at most, and one that lies below it with that
/// probability at most. `None` where there are too few values for any. NaN is not a value.
#[must_use]
pub fn bounds(values: &[f64], tails: [f64; 2]) -> [Option<f64>; 2] {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let n = sorted.len();
    // The value of this rank from one end exceeds the median if at most rank - 1 values lie beyond that end of it.
    let rank = |tail: f64| (1..=n).rev().find(|&rank| p_above(n - rank + 1, n) <= tail);
    [rank(tails[0]).map(|rank| sorted[rank - 1]), rank(tails[1]).map(|rank| sorted[n - rank])]
}

/// Fewest values with which the sign test can reject at this level: all of them on one side.
#[must_use]
pub fn fewest(level: f64) -> u64 {
    (-level.log2()).ceil().max(1.0) as u64
}

/// The probability of rejecting that the estimate of [`needed`] aims at, so that it is enough in 95% of cases although
/// it is itself estimated.
const POWER: f64 = 0.99;

/// How many values the sign test is likely to need to tell the median of such values from `limit` at this level;
/// `None` if the median cannot be told from it by any number, or there are fewer than three values.
///
/// From the distance of the median, in units of the spread of the values (median absolute deviation), follows the share
/// of values on the far side of the limit, and from that the number by the normal approximation of the binomial
/// distribution. Distance and spread are each taken one standard error to the worse, the distance at least half as large:
/// an estimate that is too small costs another attempt.
#[must_use]
pub fn needed(values: &[f64], limit: f64, level: f64) -> Option<u64> {
    let normal = Normal::standard();
    let middle = median(values)?;
    let deviations: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    let root = (values.len() as f64).sqrt();
    // Of a normal distribution, the median absolute deviation is 0.6745 standard deviations, with a standard error of
    // 1.17 / √n of it; the standard error of the median is √(π/2) standard deviations divided by √n.
    let spread = median(&deviations)? / 0.6745 * (1.0 + 1.17 / root);
    let distance = (middle - limit).abs();
    if values.len() < 3 || distance == 0.0 {
        return None;
    }
    if spread == 0.0 {
        return Some(fewest(level));
    }
    let error = std::f64::consts::FRAC_PI_2.sqrt() / root * spread;
    let distance = (distance - error).max(0.5 * distance);
    let share = normal.cdf(distance / spread);
    let [z, power] = [1.0 - level, POWER].map(|p| normal.inverse_cdf(p));
    let count = ((0.5 * z + power * (share * (1.0 - share)).sqrt()) / (share - 0.5)).powi(2);
    count.is_finite().then(|| (count.ceil() as u64).max(fewest(level)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Random;

    #[test]
    fn p_values_are_binomial() {
        // R: pbinom(9, 12, 0.5, lower.tail = FALSE) = 79/4096; 1 - pbinom(0, 3, 0.5); binom.test(15, 20, alternative =
        // "greater")$p.value.
        for (count, of, p) in
            [(10, 12, 79.0 / 4096.0), (1, 3, 0.875), (15, 20, 0.020_694_73), (6, 6, 1.0 / 64.0), (0, 0, 1.0)]
        {
            assert!((p_above(count, of) - p).abs() < 1e-7, "{count} of {of}: {}", p_above(count, of));
        }
        // Values at the limit support neither.
        let [slower, faster] = p_values(&[2.0, 2.0, 3.0], 2.0);
        assert!((slower - 0.875).abs() < 1e-9 && faster == 1.0, "{slower} and {faster}");
        assert_eq!((fewest(0.05), fewest(1.0 / 64.0)), (5, 6));
    }

    #[test]
    fn bounds_agree_with_the_test_at_every_limit() {
        let mut random = Random::new(5);
        for n in [1, 5, 6, 13, 40] {
            let values: Vec<f64> = (0..n).map(|_| random.unit()).collect();
            let tails = [0.03, 0.08];
            let [low, high] = bounds(&values, tails);
            for limit in (0..100).map(|i| f64::from(i) / 100.0) {
                let [above, below] = p_values(&values, limit);
                assert_eq!(low.is_some_and(|low| low > limit), above <= tails[0], "{n} values, {limit}");
                assert_eq!(high.is_some_and(|high| high < limit), below <= tails[1], "{n} values, {limit}");
            }
        }
        assert_eq!(bounds(&[1.0, f64::NAN, 2.0, 3.0, 4.0], [0.05; 2]), [None; 2]);
    }

    #[test]
    fn the_estimate_is_enough_in_nearly_all_cases() {
        // Normal values by the central limit theorem; mean 0.3 standard deviations above the limit.
        let draw = |random: &mut Random| 0.3 + (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
        let mut random = Random::new(9);
        let trials = 2_000;
        let enough = (0..trials).filter(|_| {
            let first: Vec<f64> = (0..20).map(|_| draw(&mut random)).collect();
            let more = needed(&first, 0.0, 0.01).map_or(5_000, |n| n.min(5_000));
            let second: Vec<f64> = (0..more).map(|_| draw(&mut random)).collect();
            p_values(&second, 0.0)[0] <= 0.01
        });
        let enough = enough.count();
        println!("enough in {enough} of {trials}");
        assert!(enough * 20 >= trials * 19, "{enough} of {trials}");
        assert_eq!((needed(&[1.0; 5], 1.0, 0.05), needed(&[2.0; 9], 1.0, 0.05)), (None, Some(5)));
    }
}
