//! `stability.csv`: one row per case and variant, RFC 4180. Unknown values are empty, never 0.
//!
//! | column | contents |
//! |---|---|
//! | `schema_version` | [`SCHEMA_VERSION`]; it rises when the meaning of a column changes |
//! | `case`, `rays`, `triangles` | what was traced |
//! | `numerics`, `accelerator`, `schedule` | how it was traced |
//! | `triangle_test` | `watertight`; `watertight_fma`, with explicit fma wherever a compiler may contract; `moller_trumbore` |
//! | `device` | `gpu`, `cpu_f32` or `cpu_f64` |
//! | `adapter` | the GPU's name |
//! | `missed`, `false_hits`, `wrong` | rays with an error |
//! | `undecided` | rays whose hit is not the exact one, where f32 cannot decide |
//! | `undecided_ceiling` | the maximum that the error bound allows |
//! | `undecidable` | rays for which the bound allows more than one result |
//! | `edge_on` | hits of a triangle that is seen exactly edge-on or has no area |
//! | `non_finite` | rays with a value in any stream that is not finite |
//! | `at_bound` | rays still active when the pass limit was reached |
//! | `passes` | passes of the run |
//! | `t_relative`, `t_ulp`, … | largest errors of t, u and v among hits of the exact triangle, see [`crate::stability::Largest`] |
//! | `expected` | `pass`; `fail`; `any` if nothing is expected |
//! | `result` | `pass`, or `fail` if there is any error or too many rays are undecided |

use std::io::Write;

use raystep_kernels::export::csv::{self, known};
use raystep_kernels::options::Numerics;

use crate::stability::{Case, Run, Variant};

/// Version of the columns.
pub const SCHEMA_VERSION: u32 = 2;

/// The columns, in order.
pub const COLUMNS: [&str; 28] = [
    "schema_version",
    "case",
    "rays",
    "triangles",
    "numerics",
    "accelerator",
    "schedule",
    "triangle_test",
    "device",
    "adapter",
    "missed",
    "false_hits",
    "wrong",
    "undecided",
    "undecided_ceiling",
    "undecidable",
    "edge_on",
    "non_finite",
    "at_bound",
    "passes",
    "t_relative",
    "t_ulp",
    "u_relative",
    "u_ulp",
    "v_relative",
    "v_ulp",
    "expected",
    "result",
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

/// Where a variant ran.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// `gpu`, `cpu_f32` or `cpu_f64`.
    pub device: &'static str,
    /// The adapter's name.
    pub adapter: String,
}

/// A row of `stability.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The case's name.
    pub case: &'static str,
    /// The variant.
    pub variant: Variant,
    /// `gpu`, `cpu_f32` or `cpu_f64`.
    pub device: &'static str,
    /// What is expected of it.
    pub expected: Expected,
    /// Whether it passed.
    pub passed: bool,
    /// Whether it has errors, not counting undecided rays.
    pub has_errors: bool,
    /// The row's text, in the order of [`COLUMNS`].
    pub fields: [String; COLUMNS.len()],
}

impl Row {
    /// The row of a run.
    #[must_use]
    pub fn new(case: &Case, triangles: usize, variant: Variant, place: &Place, run: &Run) -> Self {
        let score = &run.score;
        let rays = score.verdicts.len() as u64;
        let ceiling = case.undecided.count(rays);
        let has_errors = score.counts.errors() > 0 || score.non_finite > 0 || run.at_bound > 0;
        let passed = !has_errors && score.counts.ties <= ceiling;
        let expected = Expected::of(case, variant, place);
        let [t, u, v] = [&score.t, &score.u, &score.v];
        let number = |value: Option<f64>| known(value.map(|v| format!("{v:.3e}")));
        let [tr, tu, ur, uu, vr, vu] = [t.relative, t.ulp, u.relative, u.ulp, v.relative, v.ulp].map(number);
        let fields = [
            SCHEMA_VERSION.to_string(),
            case.name.into(),
            rays.to_string(),
            triangles.to_string(),
            variant.numerics.to_string(),
            variant.accelerator.to_string(),
            variant.schedule.to_string(),
            variant.triangle_test().into(),
            place.device.into(),
            place.adapter.clone(),
            score.counts.missed.to_string(),
            score.counts.false_hits.to_string(),
            score.counts.wrong.to_string(),
            score.counts.ties.to_string(),
            ceiling.to_string(),
            score.undecidable.to_string(),
            score.edge_on.to_string(),
            score.non_finite.to_string(),
            run.at_bound.to_string(),
            run.passes.to_string(),
            tr,
            tu,
            ur,
            uu,
            vr,
            vu,
            expected.name().into(),
            if passed { "pass" } else { "fail" }.into(),
        ];
        Self { case: case.name, variant, device: place.device, expected, passed, has_errors, fields }
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

    /// A field by its column's name; empty if there is no such column.
    #[must_use]
    pub fn field(&self, column: &str) -> &str {
        COLUMNS.iter().position(|&c| c == column).map_or("", |i| &self.fields[i])
    }
}

impl Expected {
    fn of(case: &Case, variant: Variant, place: &Place) -> Self {
        let accelerator = &variant.accelerator;
        match variant.numerics {
            Numerics::Robust => Self::Pass,
            // In f64 the paper's numerics may succeed if only rounding breaks them.
            Numerics::Paper if place.device != "cpu_f64" && case.paper.fails_on.contains(accelerator) => Self::Fail,
            Numerics::Paper => Self::Any,
        }
    }

    /// Its name in the column `expected`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::Any => "any",
        }
    }
}

/// Writes `stability.csv`.
///
/// # Errors
/// If `out` fails.
pub fn write_rows<'a>(out: impl Write, rows: impl IntoIterator<Item = &'a Row>) -> std::io::Result<()> {
    csv::write_file(out, &COLUMNS, rows.into_iter().map(|row| &row.fields[..]))
}

#[cfg(test)]
mod tests {
    use raystep_kernels::options::{Accelerator, ScheduleKind};

    use super::*;
    use crate::reference::{Counts, Verdict};
    use crate::stability::{CASES, Score};

    fn row(numerics: Numerics, device: &'static str, change: impl FnOnce(&mut Run)) -> Row {
        let case = CASES.iter().find(|case| case.name == "axis-below-1e-3").expect("a case");
        let counts = Counts { same: 998, ties: 2, ..Counts::default() };
        let score = Score { verdicts: vec![Verdict::Same; 1000], counts, ..Score::default() };
        let mut run = Run { score, passes: 7, at_bound: 0 };
        change(&mut run);
        let variant =
            Variant { numerics, accelerator: Accelerator::Grid, schedule: ScheduleKind::Compact, contracted: false };
        Row::new(case, 1280, variant, &Place { device, adapter: "a, \"b\"".into() }, &run)
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
        let mut file = Vec::new();
        write_rows(&mut file, &rows).expect("memory");
        let mut reader = ::csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
        assert_eq!(reader.headers().expect("names").iter().collect::<Vec<_>>(), COLUMNS);
        for (record, row) in reader.records().zip(&rows) {
            assert_eq!(record.expect("as many fields as names").iter().collect::<Vec<_>>(), row.fields);
        }
        assert_eq!(rows[0].field("adapter"), "a, \"b\"");
        assert_eq!((rows[0].field("t_ulp"), rows[0].field("passes")), ("", "7"), "unknown is empty, never 0");
    }
}
