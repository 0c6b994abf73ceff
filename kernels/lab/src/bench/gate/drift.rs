//! This run and an earlier one. Their times differ by the build and by the machine, which may have been busier or cooler
//! then; nothing in the two files separates the two causes for certain. What is known of the machine's part:
//!
//! - each run is cut into stretches of consecutive rounds, and the medians of a row's stretches are compared: the same
//!   build at different times within a run;
//! - a fixed piece of work that no build changes is timed before every run, and its median is compared between the runs.
//!
//! The largest of these ratios, over all rows, is the drift that was seen. Times are judged only if the limit is beyond
//! it, and then a row's interval is widened by it on both sides. The interval is that of two independent medians by order
//! statistics, at a level divided by the number of rows (Bonferroni).

use serde::Serialize;

use super::super::runs::{self, RunRow};
use super::{LEVEL, Times, Verdict};
use crate::statistics::{median, sign};

/// Fewest runs of a stretch, and most stretches of a run.
const FEWEST: usize = 5;
const STRETCHES: usize = 8;

/// Ratios of times of the same build or of the same work, each the larger divided by the smaller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drift {
    /// Between stretches of this run: the largest over all rows; 1 if there are too few runs for two stretches.
    pub within_this: f64,
    /// Between stretches of the other run.
    pub within_other: f64,
    /// Of the fixed work, this run's time divided by the other's.
    pub fixed_work_ratio: Option<f64>,
    /// The largest of them.
    pub seen: f64,
}

/// The runs of a row: this benchmark's and the earlier one's.
pub type Both<'a> = [&'a [RunRow]; 2];

/// The drift that two benchmarks show.
#[must_use]
pub fn drift(rows: &[Both<'_>]) -> Drift {
    let within = |side: usize| rows.iter().map(|row| between_stretches(row[side])).fold(1.0, f64::max);
    let fixed = |side: usize| {
        median(&rows.iter().flat_map(|row| row[side]).map(|run| run.fixed_work_ns as f64).collect::<Vec<_>>())
    };
    let fixed_work_ratio = fixed(0).zip(fixed(1)).filter(|(a, b)| *a > 0.0 && *b > 0.0).map(|(now, then)| now / then);
    let (within_this, within_other) = (within(0), within(1));
    let of_machine = fixed_work_ratio.map_or(1.0, |ratio| ratio.max(1.0 / ratio));
    Drift { within_this, within_other, fixed_work_ratio, seen: within_this.max(within_other).max(of_machine) }
}

/// The largest median of a stretch divided by the smallest.
fn between_stretches(runs: &[RunRow]) -> f64 {
    let times = runs::valid(runs).ns;
    let stretches = (times.len() / FEWEST).clamp(1, STRETCHES);
    let cut = |i: usize| times.len() * i / stretches;
    let medians: Vec<f64> = (0..stretches).filter_map(|i| median(&times[cut(i)..cut(i + 1)])).collect();
    let (low, high) = medians.iter().fold((f64::MAX, 0.0f64), |(low, high), &m| (low.min(m), high.max(m)));
    if low > 0.0 && low <= high { high / low } else { 1.0 }
}

/// Judges all rows together.
#[must_use]
pub fn judge(rows: &[Both<'_>], at_most: f64, drift: &Drift) -> Vec<Times> {
    // Two medians each get half of the level.
    let (each, all) = (LEVEL / 2.0, rows.len().max(1) as f64);
    let tails = [each / all, each];
    let row = |[now, then]: &Both<'_>| {
        let (now, then) = (runs::valid(now).ns, runs::valid(then).ns);
        let (Some(a), Some(b)) = (median(&now), median(&then).filter(|&ns| ns > 0.0)) else { return Times::unknown() };
        let [low, high] = sign::bounds(&now, tails);
        // The upper bound of the earlier median belongs to the lower bound of the ratio.
        let [then_low, then_high] = sign::bounds(&then, [tails[1], tails[0]]);
        let low = low.zip(then_high).map(|(now, then)| now / then / drift.seen);
        let high = high.zip(then_low).filter(|(_, then)| *then > 0.0).map(|(now, then)| now / then * drift.seen);
        let verdict = match (low, high) {
            _ if at_most <= drift.seen => Verdict::Undecided,
            (Some(low), _) if low > at_most => Verdict::Fail,
            (_, Some(high)) if high <= at_most => Verdict::Pass,
            _ => Verdict::Undecided,
        };
        // More runs make intervals narrower, not the drift smaller.
        let is_short = low.is_none() || high.is_none();
        let fewest = sign::fewest(tails[0]).max(sign::fewest(tails[1]));
        Times {
            time_ratio: Some(a / b),
            time_ratio_low: low,
            time_ratio_high: high,
            verdict,
            needed_repeats: (verdict == Verdict::Undecided && is_short && at_most > drift.seen).then_some(fewest),
            ..Times::unknown()
        }
    };
    rows.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs whose times vary by 2% with a period that no stretch length divides.
    fn runs(count: usize, ns: f64, fixed_work_ns: u64) -> Vec<RunRow> {
        let run = |round: usize| {
            let time_ns = Some((ns * (1.0 + 0.02 * (round * 7 % 11) as f64 / 11.0)) as u64);
            RunRow { round, time_ns, fixed_work_ns, ..RunRow::default() }
        };
        (0..count).map(run).collect()
    }

    fn verdicts(now: &[RunRow], then: &[RunRow], at_most: f64) -> (Drift, Times) {
        let rows = [[now, then]];
        let drift = drift(&rows);
        (drift, judge(&rows, at_most, &drift).remove(0))
    }

    #[test]
    fn a_limit_beyond_the_drift_is_judged_and_others_are_not() {
        let then = runs(20, 1e6, 1_000);
        let (seen, times) = verdicts(&runs(20, 1e6, 1_000), &then, 1.2);
        assert!(seen.seen > 1.0 && seen.seen < 1.03 && seen.fixed_work_ratio == Some(1.0), "{seen:?}");
        assert_eq!(times.verdict, Verdict::Pass, "{times:?}");
        let (_, slow) = verdicts(&runs(20, 1.5e6, 1_000), &then, 1.2);
        assert_eq!(slow.verdict, Verdict::Fail, "{slow:?}");
        // The same slowdown of the fixed work: the machine, not the build.
        let (seen, slow) = verdicts(&runs(20, 1.5e6, 1_500), &then, 1.2);
        assert_eq!((seen.seen, slow.verdict), (1.5, Verdict::Undecided));
        assert_eq!(verdicts(&runs(20, 1.5e6, 667), &then, 1.2).1.verdict, Verdict::Undecided);
        // A run of two halves, one of them slow.
        let halves = [runs(10, 1e6, 1_000), runs(10, 1.4e6, 1_000)].concat();
        let (seen, times) = verdicts(&halves, &then, 1.2);
        assert!(seen.within_this > 1.35 && times.verdict == Verdict::Undecided, "{seen:?}");
        assert!(verdicts(&then, &halves, 1.2).0.within_other > 1.35);
    }

    #[test]
    fn few_runs_ask_for_more() {
        let (_, times) = verdicts(&runs(5, 1e6, 1_000), &runs(20, 1e6, 1_000), 1.5);
        assert_eq!((times.verdict, times.needed_repeats), (Verdict::Undecided, Some(6)));
        let (_, none) = verdicts(&[], &runs(20, 1e6, 1_000), 1.5);
        assert_eq!(none, Times::unknown());
    }
}
