//! `stability.csv`: one row per case and configuration. Columns are described in [`crate::tidy::columns`].

use raystep_kernels::named;
use raystep_kernels::options::Numerics;
use serde::Serialize;

use crate::Hash;
use crate::configuration::Configuration;
use crate::stability::{Case, Run, triangle_test};
use crate::tidy;

/// The columns, in order.
pub const COLUMNS: &[&str] = columns![
    schema_version run_id configuration case scene_hash rays triangles numerics accelerator schedule
    triangle_test device adapter judged_rays missed false_hits wrong_hits undecided wrong_rays undecided_ceiling
    undecidable edge_on non_finite at_bound passes t_relative t_ulp u_relative u_ulp v_relative v_ulp expected
    result
];

/// What is expected of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// No errors, and no more undecided than the ceiling allows.
    Pass,
    /// At least one error.
    Fail,
    /// No expectation.
    Any,
}

/// What a case ran on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceName {
    /// `gpu`, `cpu_f32` or `cpu_f64`.
    #[serde(rename = "device")]
    pub kind: &'static str,
    /// The adapter's name.
    pub adapter: String,
}

/// A row of `stability.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The case's name.
    pub case: &'static str,
    /// The configuration.
    pub configuration: Configuration,
    /// `gpu`, `cpu_f32` or `cpu_f64`.
    pub device: &'static str,
    /// What is expected of it.
    pub expected: Expected,
    /// Whether it passed.
    pub passed: bool,
    /// Whether it has errors, not counting undecided rays.
    pub has_errors: bool,
    /// The row's text.
    pub(super) fields: tidy::Row,
}

/// What was traced.
#[derive(Clone, Copy, Debug)]
pub struct Traced<'a> {
    /// The case.
    pub case: &'a Case,
    /// Hash of its triangles.
    pub scene_hash: Hash,
    /// Number of its triangles.
    pub triangles: usize,
}

impl Row {
    /// The row of a run.
    #[must_use]
    pub fn new(run_id: &str, traced: Traced<'_>, configuration: Configuration, device: &DeviceName, run: &Run) -> Self {
        let case = traced.case;
        let score = &run.score;
        let rays = score.verdicts.len() as u64;
        // By exact t, no tie is left.
        let ceiling = if configuration.is_exact() { 0 } else { case.undecided.count(rays) };
        let has_errors = score.counts.errors() > 0 || score.non_finite > 0 || run.at_bound > 0;
        let passed = !has_errors && score.counts.ties <= ceiling;
        let expected = Expected::of(case, &configuration, device);
        let Configuration { accelerator, schedule, numerics, .. } = configuration;
        let triangle_test = triangle_test(&configuration);
        let id = [case.name, device.kind, accelerator.name(), schedule.name(), numerics.name(), triangle_test];
        let mut fields = tidy::Row::new(COLUMNS)
            .set("run_id", run_id)
            .set("configuration", id.join("/"))
            .configured(&configuration)
            .set("case", case.name)
            .set("scene_hash", traced.scene_hash)
            .set("rays", rays)
            .set("triangles", traced.triangles)
            .set("triangle_test", triangle_test)
            .with(device)
            .set("judged_rays", rays)
            .with(&score.counts)
            .set("wrong_rays", score.counts.errors())
            .set("undecided_ceiling", ceiling)
            .set("undecidable", score.undecidable)
            .set("edge_on", score.edge_on)
            .set("non_finite", score.non_finite)
            .set("at_bound", run.at_bound)
            .set("passes", run.passes)
            .set("expected", expected.name())
            .set("result", if passed { "pass" } else { "fail" });
        for (name, largest) in [("t", &score.t), ("u", &score.u), ("v", &score.v)] {
            // Four digits: it is the largest of few.
            let short = |value: Option<f64>| value.and_then(|v| format!("{v:.3e}").parse::<f64>().ok());
            fields = fields
                .set(&format!("{name}_relative"), short(largest.relative))
                .set(&format!("{name}_ulp"), short(largest.ulp));
        }
        Self { case: case.name, configuration, device: device.kind, expected, passed, has_errors, fields }
    }

    /// Whether it is as expected.
    #[must_use]
    pub fn is_as_expected(&self) -> bool {
        match self.expected {
            Expected::Pass => self.passed,
            Expected::Fail => self.has_errors,
            Expected::Any => true,
        }
    }

    /// A field by its column's name.
    #[must_use]
    pub fn field(&self, column: &str) -> &str {
        self.fields.get(column)
    }

    /// Rays with an error.
    #[must_use]
    pub fn wrong_rays(&self) -> u64 {
        self.fields.get("wrong_rays").parse().unwrap_or(0)
    }
}

named!(Expected, Pass "pass", Fail "fail", Any "any");

impl Expected {
    fn of(case: &Case, configuration: &Configuration, device: &DeviceName) -> Self {
        match configuration.numerics {
            Numerics::Robust => Self::Pass,
            // In f64 the paper's numerics may succeed if only rounding breaks them.
            Numerics::Paper if device.kind != "cpu_f64" && case.paper.fails_on.contains(&configuration.accelerator) => {
                Self::Fail
            }
            Numerics::Paper => Self::Any,
        }
    }
}

/// All rows as one table.
pub(super) fn table<'a>(rows: impl IntoIterator<Item = &'a Row>) -> tidy::Table {
    tidy::Table { columns: COLUMNS, rows: rows.into_iter().map(|row| row.fields.clone()).collect() }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::options::{Accelerator, ScheduleKind};

    use super::*;
    use crate::reference::{Counts, Verdict};
    use crate::stability::{CASES, Score};

    fn row(numerics: Numerics, device: &'static str, change: impl FnOnce(&mut Run)) -> Row {
        let usual = Configuration::usual(Accelerator::Grid, ScheduleKind::Compact);
        row_of(Configuration { numerics, ..usual }, device, change)
    }

    fn row_of(configuration: Configuration, device: &'static str, change: impl FnOnce(&mut Run)) -> Row {
        let case = CASES.iter().find(|case| case.name == "axis-below-1e-3").expect("a case");
        let counts = Counts { same: 998, ties: 2, ..Counts::default() };
        let score = Score { verdicts: vec![Verdict::Same; 1000], counts, ..Score::default() };
        let mut run = Run { score, passes: 7, at_bound: 0 };
        change(&mut run);
        let traced = Traced { case, scene_hash: Hash::default(), triangles: 1280 };
        Row::new("1-2", traced, configuration, &DeviceName { kind: device, adapter: "a, \"b\"".into() }, &run)
    }

    #[test]
    fn robust_rules_fail_by_any_error_and_by_one_undecided_ray_too_many() {
        let robust = |change: fn(&mut Run)| row(Numerics::Robust, "gpu", change);
        assert!(robust(|_| {}).is_as_expected(), "two of 1,000 rays may be undecided, and more by chance");
        let broken: [fn(&mut Run); 6] = [
            |run| run.score.counts.missed = 1,
            |run| run.score.counts.false_hits = 1,
            |run| run.score.counts.wrong = 1,
            |run| run.score.non_finite = 1,
            |run| run.score.counts.ties = 8,
            |run| run.at_bound = 1,
        ];
        for change in broken {
            let row = robust(change);
            assert!(!row.passed && !row.is_as_expected(), "{row:?}");
        }
    }

    #[test]
    fn by_exact_t_no_ray_may_be_undecided() {
        let exact = Configuration::usual(Accelerator::Bvh, ScheduleKind::Fused).exact();
        assert!(!row_of(exact, "gpu", |run| run.score.counts.ties = 1).is_as_expected());
        let row = row_of(exact, "gpu", |run| run.score.counts.ties = 0);
        assert!(row.is_as_expected());
        assert_eq!((row.field("undecided_ceiling"), row.field("triangle_test")), ("0", "exact"));
    }

    #[test]
    fn the_papers_rules_must_fail_in_f32_where_a_case_says_so() {
        let paper = |device, missed| row(Numerics::Paper, device, |run| run.score.counts.missed = missed);
        assert!(!paper("gpu", 0).is_as_expected() && paper("gpu", 1).is_as_expected());
        assert!(!paper("cpu_f32", 0).is_as_expected());
        assert!(paper("cpu_f64", 0).is_as_expected() && paper("cpu_f64", 1).is_as_expected());
        let undecided = row(Numerics::Paper, "gpu", |run| run.score.counts.ties = 900);
        assert!(!undecided.passed && !undecided.is_as_expected(), "undecided rays are no errors");
        assert_eq!((paper("gpu", 1).field("expected"), paper("cpu_f64", 1).field("expected")), ("fail", "any"));
    }

    #[test]
    fn rows_are_read_back_as_they_are() {
        let rows = [row(Numerics::Robust, "gpu", |_| {}), row(Numerics::Paper, "cpu_f64", |_| {})];
        let (mut file, table) = (Vec::new(), table(&rows));
        table.write(&mut file).expect("memory");
        assert_eq!(tidy::Table::read(COLUMNS, &file).expect("the same columns").rows, table.rows);
        assert_eq!(rows[0].field("adapter"), "a, \"b\"");
        assert_eq!((rows[0].field("t_ulp"), rows[0].field("passes")), ("", "7"), "unknown is empty, never 0");
    }
}
