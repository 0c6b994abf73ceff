//! Fills the groups of columns that files share: [`TIMES`](super::TIMES), [`RATIO`](super::RATIO) and
//! [`VERDICTS`](super::VERDICTS).

use super::Row;
use crate::reference::Counts;
use crate::statistics::interval::{self, Interval};
use crate::statistics::proportion::interval_or_bound;
use crate::statistics::{median, quantile};

/// The runs that have a time.
pub(crate) fn known(runs: &[Option<f64>]) -> Vec<f64> {
    runs.iter().copied().flatten().collect()
}

/// Fills the columns of times, but for the clock: one a run, `None` if it had no valid time.
#[must_use]
pub fn times(row: Row, runs: &[Option<f64>], seed: u32) -> Row {
    let known = known(runs);
    let interval = interval::of_median(&known, u64::from(seed));
    row.set("runs", known.len())
        .set("invalid_runs", runs.len() - known.len())
        .set("median_ns", median(&known))
        .set("low_ns", interval.map(|i| i.low))
        .set("high_ns", interval.map(|i| i.high))
        .set("min_ns", quantile(&known, 0.0))
        .set("max_ns", quantile(&known, 1.0))
        .method(interval)
}

/// Runs of two configurations in the same round, where both have a time.
pub(crate) fn pairs<'a>(of: &'a [Option<f64>], to: &'a [Option<f64>]) -> impl Iterator<Item = (f64, f64)> + 'a {
    of.iter().zip(to).filter_map(|(a, b)| Some(((*a)?, (*b)?)))
}

/// The median ratio of times in the same rounds, of their logarithms, with its interval if there are enough.
pub(crate) fn ratio_of(of: &[Option<f64>], to: &[Option<f64>], seed: u32) -> Option<(f64, Option<Interval>)> {
    let pairs: Vec<(f64, f64)> = pairs(of, to).collect();
    let logarithms: Vec<f64> = pairs.iter().map(|(a, b)| (a / b).ln()).collect();
    let interval = interval::of_ratio(&pairs, u64::from(seed));
    Some((interval.map_or(median(&logarithms)?.exp(), |interval| interval.median), interval))
}

/// Fills the columns of the ratio to another configuration, by its name.
pub(crate) fn ratio(row: Row, of: &[Option<f64>], to: &[Option<f64>], name: &str, seed: u32) -> Row {
    let ratio = ratio_of(of, to, seed);
    row.set("ratio_to", ratio.map(|_| name)).median("time_ratio", ratio)
}

/// How judged rays were chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drawn {
    /// Independently at random, or one at random in each of many parts, which only makes counts more certain
    /// (Hoeffding 1956): they have an interval.
    AtRandom,
    /// All that there are: nothing is estimated, so there is no interval.
    Census,
}

impl Drawn {
    /// How a sample of all pixels' centres was drawn.
    pub(crate) fn of_pixels(judged: usize, rays: usize) -> Self {
        if judged < rays { Self::AtRandom } else { Self::Census }
    }
}

/// Fills the columns of verdicts, but for rays without a result.
pub(crate) fn verdicts(row: Row, counts: &Counts, drawn: Drawn) -> Row {
    shares(row.with(counts), counts.errors(), counts.rays(), drawn)
}

/// Fills the columns of wrong rays among judged ones.
pub(crate) fn shares(row: Row, wrong: u64, judged: u64, drawn: Drawn) -> Row {
    let ends = interval_or_bound(wrong, judged).filter(|_| drawn == Drawn::AtRandom);
    row.set("judged_rays", judged)
        .set("wrong_rays", wrong)
        .set("wrong_per_million", per_million(wrong, judged))
        .ends("wrong_per_million", ends.map(|ends| ends.map(|share| 1e6 * share)))
}

/// A share of rays; `None` of none.
pub(crate) fn per_million(count: u64, of: u64) -> Option<f64> {
    (of > 0).then(|| 1e6 * count as f64 / of as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tidy::{RATIO, TIMES, VERDICTS, count, joined};

    const GROUPS: &[&[&str]] = &[&["schema_version"], TIMES, RATIO, VERDICTS];
    const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

    fn runs(n: u32) -> Vec<Option<f64>> {
        (1..=n).map(|k| Some(f64::from(k) * 100.0)).collect()
    }

    #[test]
    fn times_have_an_interval_from_six_runs_on() {
        let fields = |runs: &[Option<f64>]| {
            let row = times(Row::new(COLUMNS), runs, 0);
            ["runs", "invalid_runs", "median_ns", "low_ns", "high_ns", "max_ns", "interval_method"]
                .map(|f| row.get(f).to_owned())
        };
        assert_eq!(fields(&runs(7)), ["7", "0", "400", "100", "700", "700", "order_statistics"]);
        assert_eq!(fields(&runs(3)), ["3", "0", "200", "", "", "300", ""]);
        assert_eq!(fields(&[None, Some(5.0)]), ["1", "1", "5", "", "", "5", ""]);
        assert_eq!(fields(&[]), ["0", "0", "", "", "", "", ""]);
    }

    #[test]
    fn ratios_are_of_the_same_rounds() {
        let row = ratio(Row::new(COLUMNS), &runs(7), &[Some(100.0); 7], "other", 0);
        assert_eq!((row.get("time_ratio"), row.get("time_ratio_low"), row.get("ratio_to")), ("4", "1", "other"));
        // Of two ratios, the geometric mean: what is twice as fast here and as slow there is alike.
        let two = ratio(Row::new(COLUMNS), &[Some(2.0), None, Some(1.0)], &[Some(1.0), Some(9.0), Some(2.0)], "o", 0);
        assert_eq!((two.get("time_ratio"), two.get("time_ratio_low")), ("1", ""));
        assert_eq!(ratio(Row::new(COLUMNS), &runs(3), &[None; 3], "other", 0).get("ratio_to"), "");
    }

    #[test]
    fn without_a_wrong_ray_the_bound_is_one_sided_and_a_census_has_none() {
        let counts = Counts { same: 2990, ties: 10, ..Counts::default() };
        let row = verdicts(Row::new(COLUMNS), &counts, Drawn::AtRandom);
        assert_eq!((row.get("wrong_rays"), row.get("undecided"), row.get("judged_rays")), ("0", "10", "3000"));
        let high = row.number("wrong_per_million_high").expect("a bound");
        assert!((high - 998.1).abs() < 0.5, "3 of 3,000 in a million: {high}");
        let census = verdicts(Row::new(COLUMNS), &counts, Drawn::of_pixels(3000, 3000));
        assert_eq!((census.get("wrong_per_million"), census.get("wrong_per_million_high")), ("0", ""));
        assert_eq!(Drawn::of_pixels(10, 11), Drawn::AtRandom);
    }
}
