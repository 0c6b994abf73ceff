//! Lines through times, and where two of them cross.

/// `y = intercept + slope * x`
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) intercept: f64,
    pub(crate) slope: f64,
    /// Largest distance of a point from the line, as a share of the point's y.
    pub(crate) worst: f64,
}

impl Line {
    /// Least squares. `None` where there are fewer than two different x.
    pub(crate) fn through(points: &[(f64, f64)]) -> Option<Self> {
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

/// The x from which on `b` is below `a` for good, by straight lines between points `[x, a, b]` on logarithmic axes,
/// x ascending. `None` where `b` is not below at the end, or never was above.
pub(crate) fn crossover(points: &[[f64; 3]]) -> Option<f64> {
    let last = points.iter().rposition(|[_, a, b]| b >= a)?;
    let [p, q] = [*points.get(last)?, *points.get(last + 1)?].map(|point| point.map(f64::ln));
    let (before, after) = (p[2] - p[1], q[2] - q[1]);
    Some((p[0] + (q[0] - p[0]) * before / (before - after)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_with_what_it_misses() {
        let exact = Line::through(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]).expect("a line");
        assert!((exact.intercept - 3.0).abs() < 1e-12 && (exact.slope - 2.0).abs() < 1e-12 && exact.worst < 1e-12);
        // By hand: slope 1, intercept 1/3; the middle point, 1, is 1/3 below its line.
        let off = Line::through(&[(0.0, 0.5), (1.0, 1.0), (2.0, 2.5)]).expect("a line");
        assert!((off.slope - 1.0).abs() < 1e-12 && (off.intercept - 1.0 / 3.0).abs() < 1e-12);
        assert!((off.worst - 1.0 / 3.0).abs() < 1e-12, "{off:?}");
        assert_eq!(Line::through(&[(1.0, 5.0), (1.0, 6.0)]), None);
    }

    #[test]
    fn lines_cross_where_logarithms_say() {
        // a = x, b = 100 / x cross at 10, and log-log interpolation is exact for powers.
        let x = [1.0, 4.0, 40.0, 1000.0];
        let at = crossover(&x.map(|x| [x, x, 100.0 / x])).expect("they cross");
        assert!((at - 10.0).abs() < 1e-9, "{at}");
        assert_eq!(crossover(&x.map(|x| [x, 100.0 / x, x])), None, "a ends above");
        // Below from the beginning is no crossing; what counts is the last.
        assert_eq!(crossover(&x.map(|x| [x, x, x / 2.0])), None);
        let wavy = [[1.0, 1.0, 0.5], [4.0, 4.0, 8.0], [40.0, 40.0, 20.0], [1000.0, 1000.0, 10.0]];
        let at = crossover(&wavy).expect("they cross");
        assert!(at > 4.0 && at < 40.0, "{at}");
        // What ends above has not crossed yet.
        assert!(crossover(&wavy[..2]).is_none() && crossover(&[]).is_none());
    }
}
