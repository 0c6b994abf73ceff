//! Statistics of counts and times: intervals, tests, fitted lines, mean errors.

pub mod bias;
mod compared;
pub mod interval;
pub mod proportion;
pub mod sign;

pub use compared::{Compared, EQUIVALENT};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Farthest a point may lie from a [`Line`], relative to its y: beyond it, the points are not on a line, and its slope is
/// no rate of theirs.
const FARTHEST: f64 = 0.25;

/// `y = intercept + slope * x`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// y at x = 0, at least 0.
    pub intercept: f64,
    /// Increase of y per unit of x, above 0.
    pub slope: f64,
    /// The 95% confidence interval of the slope (Student 1908); `None` if there are no more points than unknowns.
    pub slope_interval: Option<[f64; 2]>,
    /// Largest distance of a point from the line, relative to the point's y.
    pub worst: f64,
}

impl Line {
    /// The line through times: least squares of the distances relative to y, because a long time is off by more than a
    /// short one, and with an intercept of at least 0, because nothing takes less than no time. Points whose y is not
    /// above 0 are left out. `None` if fewer than two different x remain, if the line does not rise, or if the points
    /// are not on a line: one is more than a quarter of its y away.
    #[must_use]
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        let points: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.0.is_finite() && p.1 > 0.0).collect();
        let sum = |f: fn(f64, f64) -> f64| points.iter().map(|&(x, y)| f(x, y) / (y * y)).sum::<f64>();
        let (w, wx, wxx, wy, wxy) =
            (sum(|_, _| 1.0), sum(|x, _| x), sum(|x, _| x * x), sum(|_, y| y), sum(|x, y| x * y));
        let spread = wxx - wx * wx / w;
        if points.len() < 2 || spread.is_nan() || spread <= 1e-12 * wxx {
            return None;
        }
        let (slope, unknowns, information) = match (wxy - wx * wy / w) / spread {
            slope if wy >= slope * wx => (slope, 2, spread),
            // The intercept would be negative.
            _ => (wxy / wxx, 1, wxx),
        };
        let intercept = if unknowns == 2 { (wy - slope * wx) / w } else { 0.0 };
        let off = || points.iter().map(|&(x, y)| (intercept + slope * x - y) / y);
        let worst = off().map(f64::abs).fold(0.0, f64::max);
        let free = points.len() - unknowns;
        let interval = (free > 0).then_some(free as f64).and_then(|free| {
            let error = (off().map(|d| d * d).sum::<f64>() / free / information).sqrt();
            let reach = StudentsT::new(0.0, 1.0, free).ok()?.inverse_cdf(0.975) * error;
            Some([slope - reach, slope + reach])
        });
        (slope > 0.0 && worst <= FARTHEST).then_some(Self { intercept, slope, slope_interval: interval, worst })
    }
}

/// The exponent b of `y = a * x^b` fitted to points, by least squares of their logarithms. Points with values that are
/// not above 0 are ignored; `None` if fewer than two different x remain.
#[must_use]
pub fn power_law(points: &[(f64, f64)]) -> Option<f64> {
    let is_positive = |p: &&(f64, f64)| p.0 > 0.0 && p.1 > 0.0;
    let logarithms: Vec<_> = points.iter().filter(is_positive).map(|p| (p.0.ln(), p.1.ln())).collect();
    let n = logarithms.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| logarithms.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = logarithms.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    (spread > 0.0).then(|| logarithms.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread)
}

/// The root mean square; `None` without values.
#[must_use]
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0u64), |(sum, count), v| (sum + v * v, count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// The value below which `share` (0 to 1) of the values lie: linear interpolation between sorted values (Hyndman and
/// Fan 1996, definition 7). NaN is ignored; `None` without values.
#[must_use]
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let place = share.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    Some(if below == above { below } else { below + (above - below) * place.fract() })
}

/// The median; `None` without values.
#[must_use]
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn a_line_is_found_with_what_it_misses_or_there_is_none() {
        let exact = Line::through(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]).expect("a line");
        assert!(is_near(exact.intercept, 3.0) && is_near(exact.slope, 2.0) && exact.worst < 1e-12);
        // The normal equations with weights 1 / y², solved with NumPy; t(0.975, 1) = 12.7062.
        let off = Line::through(&[(1.0, 1.1), (2.0, 1.9), (4.0, 4.0)]).expect("a line");
        assert!((off.slope - 0.9242265).abs() < 1e-6 && (off.intercept - 0.1530846).abs() < 1e-6, "{off:?}");
        let [low, high] = off.slope_interval.expect("an interval");
        assert!((low - -0.1511520).abs() < 1e-5 && (high - 1.9996051).abs() < 1e-5, "{off:?}");
        // Two points have no interval; and below 0 no time can begin.
        assert_eq!(Line::through(&[(1.0, 2.0), (2.0, 3.0)]).map(|line| line.slope_interval), Some(None));
        let from_0 = Line::through(&[(1.0, 0.9), (2.0, 2.1), (3.0, 3.2)]).expect("a line");
        // (Σ x/y) / (Σ x²/y²)
        assert!(from_0.intercept == 0.0 && (from_0.slope - 0.993_540).abs() < 1e-6, "{from_0:?}");
        // Curved, falling, or only one x.
        assert_eq!(Line::through(&[(1.0, 1.0), (2.0, 4.0), (4.0, 16.0), (8.0, 64.0)]), None);
        assert_eq!(Line::through(&[(1.0, 3.0), (2.0, 2.9), (3.0, 2.8)]), None);
        assert_eq!((Line::through(&[(1.0, 5.0), (1.0, 6.0)]), Line::through(&[])), (None, None));
    }

    #[test]
    fn a_power_law_has_its_exponent_and_leaves_out_zeros() {
        let falls = [1.0, 4.0, 16.0, 64.0].map(|x: f64| (x, 3.0 * x.powf(-0.5)));
        assert!(power_law(&falls).is_some_and(|b| is_near(b, -0.5)));
        let with_zero = [&falls[..], &[(256.0, 0.0)]].concat();
        assert!(power_law(&with_zero).is_some_and(|b| is_near(b, -0.5)));
        assert_eq!((power_law(&falls[..1]), power_law(&[(1.0, 0.0), (2.0, 0.0)])), (None, None));
    }

    #[test]
    fn means_and_quantiles_are_those_done_by_hand() {
        assert!(root_mean_square([3.0, -4.0, 0.0, 0.0]).is_some_and(|v| is_near(v, 2.5)));
        assert_eq!(root_mean_square([]), None);
        let values = [40.0, 15.0, f64::NAN, 50.0, 35.0, 20.0];
        assert_eq!(quantile(&values, 0.5), Some(35.0));
        assert!(quantile(&values, 0.05).is_some_and(|v| is_near(v, 16.0)));
        assert_eq!((quantile(&values, 1.0), quantile(&[f64::NAN], 0.5)), (Some(50.0), None));
        assert_eq!(quantile(&[f64::INFINITY; 2], 0.3), Some(f64::INFINITY));
    }
}
