//! A row of `stiff.csv`: one structure, with all rules or without one, at one point of a family.

use std::time::Duration;

use crate::reference::Counts;
use crate::statistics::interval;
use crate::statistics::proportion::{at_most, exact_interval};
use crate::statistics::{median, quantile};
use crate::tidy::Row;

/// The columns of `stiff.csv`.
pub const COLUMNS: &[&str] = &[
    "schema_version",
    "run_id",
    "configuration",
    "family",
    "parameter",
    "scene",
    "scene_hash",
    "triangles",
    "adapter",
    "version",
    "seed",
    "is_quick",
    "accelerator",
    "schedule",
    "numerics",
    "rule",
    "stratum",
    "rays",
    "clock",
    "runs",
    "invalid_runs",
    "median_ns",
    "low_ns",
    "high_ns",
    "min_ns",
    "max_ns",
    "ns_per_ray",
    "interval_method",
    "interval_level",
    "is_lower_bound",
    "time_ratio",
    "time_ratio_low",
    "time_ratio_high",
    "ratio_to",
    "build_s",
    "hits",
    "judged_rays",
    "missed",
    "false_hits",
    "wrong_hits",
    "undecided",
    "wrong_rays",
    "wrong_per_million",
    "wrong_per_million_low",
    "wrong_per_million_high",
    "at_bound",
    "passes",
    "cells_per_ray",
    "tests_per_ray",
    "structure_bytes",
    "predicted_line",
    "stiffness",
];

/// The columns of `runs.csv`: one row a timed run.
pub const RUN_COLUMNS: &[&str] =
    &["schema_version", "run_id", "configuration", "round", "place", "time_ns", "wall_ns", "clock"];

/// Seed of bootstraps.
const BOOTSTRAP: u64 = 2007;

/// A run's rays, judged.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Verdicts {
    pub(super) counts: Counts,
    pub(super) hits: u64,
    /// Rays without a result.
    pub(super) at_bound: u64,
}

impl Verdicts {
    pub(super) fn fill(&self, row: Row) -> Row {
        let (rays, wrong) = (self.counts.rays(), self.counts.errors());
        let ends = exact_interval(wrong, rays);
        // If none is wrong, only the upper end says something: one-sided.
        let high = if wrong == 0 { at_most(0, rays) } else { ends.map(|[_, high]| high) };
        row.set("hits", self.hits)
            .set("judged_rays", rays)
            .set("missed", self.counts.missed)
            .set("false_hits", self.counts.false_hits)
            .set("wrong_hits", self.counts.wrong)
            .set("undecided", self.counts.ties)
            .set("wrong_rays", wrong)
            .set("wrong_per_million", (rays > 0).then(|| 1e6 * wrong as f64 / rays as f64))
            .set("wrong_per_million_low", ends.map(|[low, _]| 1e6 * low))
            .set("wrong_per_million_high", high.map(|high| 1e6 * high))
            .set("at_bound", self.at_bound)
    }
}

/// Fills the times of runs with this many rays. A stopped run's time so far is a lower bound.
pub(super) fn times(row: Row, runs: &[Option<f64>], stopped: Option<Duration>, rays: usize) -> Row {
    let known: Vec<f64> = runs.iter().copied().flatten().collect();
    let middle = stopped.map(|spent| spent.as_nanos() as f64).or_else(|| median(&known));
    let interval = interval::of_median(&known, BOOTSTRAP).filter(|_| stopped.is_none());
    row.set("runs", known.len())
        .set("invalid_runs", runs.len() - known.len())
        .set("median_ns", middle)
        .set("low_ns", interval.map(|i| i.low))
        .set("high_ns", interval.map(|i| i.high))
        .set("min_ns", quantile(&known, 0.0))
        .set("max_ns", quantile(&known, 1.0))
        .set("ns_per_ray", middle.filter(|_| rays > 0).map(|ns| ns / rays as f64))
        .set("interval_method", interval.map(|i| i.method.name()))
        .set("interval_level", interval.map(|i| i.level))
        .set("is_lower_bound", stopped.is_some())
}

/// Fills the ratio of times to those of another configuration in the same rounds.
pub(super) fn ratio(row: Row, runs: &[Option<f64>], to: &[Option<f64>], other: String) -> Row {
    let pairs: Vec<(f64, f64)> = runs.iter().zip(to).filter_map(|(a, b)| Some(((*a)?, (*b)?))).collect();
    let ratios: Vec<f64> = pairs.iter().map(|(a, b)| a / b).collect();
    let interval = interval::of_ratio(&pairs, BOOTSTRAP);
    row.set("time_ratio", median(&ratios))
        .set("time_ratio_low", interval.map(|i| i.low))
        .set("time_ratio_high", interval.map(|i| i.high))
        .set("ratio_to", other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_an_interval_from_six_runs_and_a_stopped_run_is_a_lower_bound() {
        let some = |n: u32| (1..=n).map(|k| Some(f64::from(k) * 100.0)).collect::<Vec<_>>();
        let row = times(Row::new(COLUMNS), &some(7), None, 10);
        let fields = ["runs", "median_ns", "ns_per_ray", "low_ns", "high_ns", "interval_method", "is_lower_bound"];
        assert_eq!(fields.map(|f| row.get(f)), ["7", "400", "40", "100", "700", "order_statistics", "false"]);
        let row = times(Row::new(COLUMNS), &some(3), None, 10);
        assert_eq!(fields.map(|f| row.get(f)), ["3", "200", "20", "", "", "", "false"]);
        let row = times(Row::new(COLUMNS), &[], Some(Duration::from_micros(5)), 10);
        assert_eq!(fields.map(|f| row.get(f)), ["0", "5000", "500", "", "", "", "true"]);
        let row = ratio(Row::new(COLUMNS), &some(7), &[Some(100.0); 7], "other".into());
        assert_eq!((row.get("time_ratio"), row.get("ratio_to")), ("4", "other"));
    }

    #[test]
    fn without_a_wrong_ray_the_bound_is_one_sided() {
        let counts = Counts { same: 2990, ties: 10, ..Counts::default() };
        let row = Verdicts { counts, hits: 2990, at_bound: 0 }.fill(Row::new(COLUMNS));
        assert_eq!((row.get("wrong_rays"), row.get("undecided"), row.get("judged_rays")), ("0", "10", "3000"));
        let high = row.number("wrong_per_million_high").expect("a bound");
        assert!((high - 998.1).abs() < 0.5, "3 of 3,000 in a million: {high}");
    }
}
