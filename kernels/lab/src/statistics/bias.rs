//! Bias and variance of an estimator of many values, apart.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The parts of a mean square error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apart {
    /// Mean over all values of the squared bias: an estimate without bias of its own, which is below 0 by chance where there is
    /// none.
    pub bias_squared: f64,
    /// Its 95% interval, by the jackknife (Tukey 1958); `None` for fewer than three estimates.
    pub interval: Option<[f64; 2]>,
    /// Mean over all values of the variance of one estimate.
    pub variance: f64,
}

impl Apart {
    /// Of independent estimates of the values in `truth`, which is itself off by `off`, a root mean square error that is
    /// independent of theirs. `None` for fewer than two estimates, or for other numbers of values.
    ///
    /// The square of the mean difference is too large by the variance of that mean, which is subtracted: what is left is the
    /// mean product of the differences of two different estimates.
    #[must_use]
    pub fn of(estimates: &[Vec<f64>], truth: &[f64], off: f64) -> Option<Self> {
        let (n, values) = (estimates.len() as f64, truth.len() as f64);
        if estimates.len() < 2 || truth.is_empty() || estimates.iter().any(|one| one.len() != truth.len()) {
            return None;
        }
        let products = |sum: f64, squares: f64, n: f64| (sum * sum - squares) / (n * (n - 1.0) * values);
        let (mut bias_squared, mut variance, mut without) = (0.0, 0.0, vec![0.0; estimates.len()]);
        for (value, &truth) in truth.iter().enumerate() {
            let differences = || estimates.iter().map(|one| one[value] - truth);
            let (sum, squares) = differences().fold((0.0, 0.0), |(sum, squares), d| (sum + d, squares + d * d));
            let mean = sum / n;
            bias_squared += products(sum, squares, n);
            variance += differences().map(|d| (d - mean) * (d - mean)).sum::<f64>() / ((n - 1.0) * values);
            for (without, d) in without.iter_mut().zip(differences()) {
                *without += products(sum - d, squares - d * d, n - 1.0);
            }
        }
        bias_squared -= off * off;
        let interval = StudentsT::new(0.0, 1.0, n - 1.0).ok().filter(|_| estimates.len() > 2).map(|student| {
            let mean = without.iter().sum::<f64>() / n;
            let squares = without.iter().map(|one| (one - mean) * (one - mean)).sum::<f64>();
            let reach = student.inverse_cdf(0.975) * ((n - 1.0) / n * squares).sqrt();
            [bias_squared - reach, bias_squared + reach]
        });
        Some(Self { bias_squared, interval, variance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Random;

    /// Two estimates on either side of what they estimate have no bias that could be told; shifted ones have.
    #[test]
    fn parts_are_those_of_closed_forms() {
        let found = Apart::of(&[vec![3.0, 1.0], vec![1.0, 1.0], vec![3.0, 1.0], vec![1.0, 1.0]], &[1.5, 1.0], 0.0);
        let found = found.expect("four estimates");
        // Of the first value, the mean is off by 1/2 and the variance is 4/3, a third of which is that of the mean.
        assert!((found.variance - 2.0 / 3.0).abs() < 1e-12, "{found:?}");
        assert!((found.bias_squared - 0.5 * (0.25 - 1.0 / 3.0)).abs() < 1e-12, "{found:?}");
        let exact = Apart::of(&[vec![2.0], vec![2.0], vec![2.0]], &[1.0], 0.5).expect("three estimates");
        assert_eq!((exact.bias_squared, exact.variance, exact.interval), (0.75, 0.0, Some([0.75, 0.75])));
        assert!(Apart::of(&[vec![1.0], vec![1.0]], &[1.0], 0.0).is_some_and(|two| two.interval.is_none()));
        assert_eq!(Apart::of(&[vec![1.0]], &[1.0], 0.0), None);
        assert_eq!(Apart::of(&[vec![1.0], vec![1.0, 2.0]], &[1.0], 0.0), None);
    }

    /// In nine of ten experiments or more, the interval of 95% has the square of the bias.
    #[test]
    fn the_interval_has_the_true_bias() {
        let mut random = Random::new(46);
        let truth = vec![0.0; 200];
        for bias in [0.0, 0.1] {
            let mut inside = 0;
            for _ in 0..200 {
                // Variance 1/12.
                let estimate = |random: &mut Random| truth.iter().map(|_| random.unit() - 0.5 + bias).collect();
                let estimates: Vec<Vec<f64>> = (0..10).map(|_| estimate(&mut random)).collect();
                let found = Apart::of(&estimates, &truth, 0.0).expect("ten estimates");
                assert!((found.variance * 12.0 - 1.0).abs() < 0.2, "{found:?}");
                inside += usize::from(found.interval.is_some_and(|[low, high]| (low..=high).contains(&(bias * bias))));
            }
            assert!(inside >= 180, "{bias}: {inside} of 200");
        }
    }
}
