//! A row of `stiff.csv`: one structure, with all rules or without one, at one point of a family.

use std::time::Duration;

use crate::reference::Counts;
use crate::tidy::fill::{self, Drawn};
use crate::tidy::{KEYS, RATIO, Row, TIMES, VERDICTS, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![family parameter triangles version seed is_quick],
    columns![integrator accelerator schedule numerics rule stratum rays ns_per_ray is_lower_bound],
    TIMES,
    RATIO,
    VERDICTS,
    columns![build_s hits passes cells_per_ray tests_per_ray structure_bytes],
    &["predicted_line", "stiffness"],
    columns![shadow_rays undecided_shadow_rays wrong_shadow_rays wrong_shadow_per_million close_shadow_starts],
    columns![light_error_median light_error_largest lit_otherwise_rays],
];

/// The columns of `stiff.csv`.
pub const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// The columns of `runs.csv`: one row a timed run.
pub const RUN_COLUMNS: &[&str] = columns![schema_version run_id configuration round place time_ns wall_ns clock];

/// Seed of bootstraps.
const BOOTSTRAP: u32 = 2007;

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
        fill::verdicts(row, &self.counts, Drawn::AtRandom).set("hits", self.hits).set("at_bound", self.at_bound)
    }
}

/// Fills the times of runs with this many rays. A stopped run's time so far is a lower bound.
pub(super) fn times(row: Row, runs: &[Option<f64>], stopped: Option<Duration>, rays: usize) -> Row {
    let row = match stopped {
        None => fill::times(row, runs, BOOTSTRAP),
        Some(spent) => fill::times(row, &[], BOOTSTRAP).set("median_ns", spent.as_nanos() as f64),
    };
    let per_ray = row.number("median_ns").filter(|_| rays > 0).map(|ns| ns / rays as f64);
    row.set("ns_per_ray", per_ray).set("is_lower_bound", stopped.is_some())
}

/// Fills the ratio of times to those of another configuration in the same rounds.
pub(super) fn ratio(row: Row, runs: &[Option<f64>], to: &[Option<f64>], other: &str) -> Row {
    fill::ratio(row, runs, to, other, BOOTSTRAP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stopped_run_is_a_lower_bound() {
        let fields = ["runs", "median_ns", "ns_per_ray", "low_ns", "is_lower_bound"];
        let some: Vec<Option<f64>> = (1..=7).map(|k| Some(f64::from(k) * 100.0)).collect();
        let row = times(Row::new(COLUMNS), &some, None, 10);
        assert_eq!(fields.map(|f| row.get(f)), ["7", "400", "40", "100", "false"]);
        let row = times(Row::new(COLUMNS), &[], Some(Duration::from_micros(5)), 10);
        assert_eq!(fields.map(|f| row.get(f)), ["0", "5000", "500", "", "true"]);
    }
}
