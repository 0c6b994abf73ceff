//! Straight lines through times, and where two measured curves cross.

pub(crate) use raystep_lab::statistics::Line;

/// The x from which `b` stays below `a`, by linear interpolation on logarithmic axes between points `[x, a, b]`,
/// x ascending. `None` if `b` is not below at the end, or was never above.
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
    fn lines_cross_where_logarithms_say() {
        // a = x, b = 100 / x cross at 10, and log-log interpolation is exact for powers.
        let x = [1.0, 4.0, 40.0, 1000.0];
        let at = crossover(&x.map(|x| [x, x, 100.0 / x])).expect("they cross");
        assert!((at - 10.0).abs() < 1e-9, "{at}");
        assert_eq!(crossover(&x.map(|x| [x, 100.0 / x, x])), None, "a ends above");
        // If b is below from the start, nothing crosses; of several crossings, the last one counts.
        assert_eq!(crossover(&x.map(|x| [x, x, x / 2.0])), None);
        let wavy = [[1.0, 1.0, 0.5], [4.0, 4.0, 8.0], [40.0, 40.0, 20.0], [1000.0, 1000.0, 10.0]];
        let at = crossover(&wavy).expect("they cross");
        assert!(at > 4.0 && at < 40.0, "{at}");
        // b ends above a, so it has not crossed for good.
        assert!(crossover(&wavy[..2]).is_none() && crossover(&[]).is_none());
    }
}
