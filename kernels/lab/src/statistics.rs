//! Statistics of counts and times: intervals, tests, fitted lines, mean errors.

pub mod interval;
pub mod proportion;
pub mod sign;

/// `y = intercept + slope * x`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// y at x = 0.
    pub intercept: f64,
    /// Increase of y per unit of x.
    pub slope: f64,
    /// Largest distance of a point from the line, relative to the point's y.
    pub worst: f64,
}

impl Line {
    /// Least squares. `None` if there are fewer than two different x.
    #[must_use]
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
        if points.len() < 2 || spread <= 0.0 {
            return None;
        }
        let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
        let intercept = y - slope * x;
        let worst = points.iter().map(|p| ((intercept + slope * p.0 - p.1) / p.1).abs()).fold(0.0, f64::max);
        Some(Self { intercept, slope, worst })
    }
}

/// The exponent b of `y = a * x^b` fitted to points, by least squares of their logarithms. Points with values that are
/// not above 0 are ignored; `None` if fewer than two different x remain.
#[must_use]
pub fn power_law(points: &[(f64, f64)]) -> Option<f64> {
    let is_positive = |p: &&(f64, f64)| p.0 > 0.0 && p.1 > 0.0;
    let logarithms: Vec<_> = points.iter().filter(is_positive).map(|p| (p.0.ln(), p.1.ln())).collect();
    Line::through(&logarithms).map(|line| line.slope)
}

/// The root mean square; `None` without values.
#[must_use]
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0u64), |(sum, count), v| (sum + v * v, count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// The definition of percentiles, for reports: NumPy's and R's default, in "Sample Quantiles in Statistical Packages".
pub const PERCENTILES: &str = "linear interpolation between sorted times (Hyndman and Fan 1996, definition 7)";

/// The value below which `share` (0 to 1) of the values lie, by [`PERCENTILES`]. NaN is ignored; `None` without values.
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

/// The median of some times, and their spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Half of the values are below.
    pub median: f64,
    /// 5% of the values are below.
    pub p05: f64,
    /// 5% of the values are above.
    pub p95: f64,
}

impl Spread {
    /// `None` without values.
    #[must_use]
    pub fn of(times: &[f64]) -> Option<Self> {
        let at = |share| quantile(times, share);
        Some(Self { median: at(0.5)?, p05: at(0.05)?, p95: at(0.95)? })
    }
}

/// Minimum number of values for a 5th and 95th percentile.
const FEWEST_FOR_PERCENTILES: usize = 20;

/// The 5th and 95th percentile, or minimum and maximum if there are few values.
#[must_use]
pub fn low_and_high(values: &[f64]) -> [Option<f64>; 2] {
    let ends = if values.len() < FEWEST_FOR_PERCENTILES { [0.0, 1.0] } else { [0.05, 0.95] };
    ends.map(|share| quantile(values, share))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn a_line_is_found_with_what_it_misses() {
        let exact = Line::through(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]).expect("a line");
        assert!((exact.intercept - 3.0).abs() < 1e-12 && (exact.slope - 2.0).abs() < 1e-12 && exact.worst < 1e-12);
        // Computed by hand: slope 1, intercept 1/3; the middle point, 1, is 1/3 below its line.
        let off = Line::through(&[(0.0, 0.5), (1.0, 1.0), (2.0, 2.5)]).expect("a line");
        assert!((off.slope - 1.0).abs() < 1e-12 && (off.intercept - 1.0 / 3.0).abs() < 1e-12);
        assert!((off.worst - 1.0 / 3.0).abs() < 1e-12, "{off:?}");
        assert_eq!(Line::through(&[(1.0, 5.0), (1.0, 6.0)]), None);
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

    #[test]
    fn percentiles_are_numpys() {
        // numpy.percentile([15, 20, 35, 40, 50], [5, 50, 95]); likewise of a single value.
        let spread = Spread::of(&[40.0, 15.0, 50.0, 35.0, 20.0]).expect("times");
        assert_eq!(spread.median, 35.0);
        assert!((spread.p05 - 16.0).abs() < 1e-9 && (spread.p95 - 48.0).abs() < 1e-9, "{spread:?}");
        assert_eq!(Spread::of(&[3.0, 4.0]).map(|s| s.median), Some(3.5));
        assert_eq!(Spread::of(&[7.0]), Some(Spread { median: 7.0, p05: 7.0, p95: 7.0 }));
        assert_eq!(Spread::of(&[]), None);
    }

    #[test]
    fn few_values_have_ends_and_many_have_percentiles() {
        let values = |n: u32| (0..n).map(f64::from).collect::<Vec<_>>();
        assert_eq!(low_and_high(&values(19)), [Some(0.0), Some(18.0)]);
        assert_eq!(low_and_high(&values(21)), [Some(1.0), Some(19.0)]);
        assert_eq!(low_and_high(&[]), [None; 2]);
    }
}
