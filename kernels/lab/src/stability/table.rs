//! The results as text: one line per case, and one for everything that is not as expected.

use raystep_kernels::{Accelerator, Numerics, ScheduleKind};

use super::{Case, Outcome, Row, Truth};
use crate::text::aligned;

/// A configuration as text.
pub(super) fn in_words(row: &Row) -> String {
    let v = &row.configuration;
    let fused = if v.schedule == ScheduleKind::Fused { " fused" } else { "" };
    let contracted = if v.contracted { " fma" } else { "" };
    let exact = if v.is_exact() { " by exact t" } else { "" };
    format!("{} {}{fused}{contracted}{exact} {}", v.numerics, v.accelerator, row.device)
}

/// A run as text.
pub(super) fn name(row: &Row) -> String {
    format!("{}, {}", row.case, in_words(row))
}

impl Row {
    /// A run's result in one line, with what was expected of it.
    #[must_use]
    pub fn result(&self) -> String {
        let fields = ["missed", "false_hits", "wrong_hits", "undecided", "non_finite", "at_bound"];
        let counts = fields.map(|c| format!("{} {c}", self.field(c))).join(", ");
        format!("{}: {counts}; expected to {}", name(self), self.field("expected"))
    }
}

/// The maximum over some runs; a dash if there are none.
fn most(rows: &[Row], is_one: impl Fn(&Row) -> bool, count: impl Fn(&Row) -> u64) -> String {
    rows.iter().filter(|row| is_one(row)).map(count).max().map_or("-".into(), |n| n.to_string())
}

/// Headings of [`summary`].
pub(super) const SUMMARY: [&str; 10] = [
    "case",
    "rays",
    "robust errors",
    "undecided",
    "undecided limit",
    "undecided by exact t",
    "paper grid errors",
    "paper bvh errors",
    "paper none errors",
    "as expected",
];

/// A case in one line: the most errors of all configurations.
pub(super) fn summary(outcome: &Outcome) -> [String; 10] {
    let rows = &outcome.rows;
    let is_robust = |row: &Row| row.configuration.numerics == Numerics::Robust;
    let is_exact = |row: &Row| row.configuration.is_exact();
    let number = |column: &'static str| move |row: &Row| row.field(column).parse().unwrap_or(0);
    let paper = |accelerator: Accelerator| {
        most(
            rows,
            |r| !is_robust(r) && r.configuration.accelerator == accelerator && r.device != "cpu_f64",
            Row::wrong_rays,
        )
    };
    let not = rows.iter().filter(|row| !row.is_as_expected()).count();
    [
        outcome.case.name.to_owned(),
        most(rows, |_| true, number("rays")),
        most(rows, is_robust, Row::wrong_rays),
        most(rows, is_robust, number("undecided")),
        most(rows, |_| true, number("undecided_ceiling")),
        most(rows, is_exact, number("undecided")),
        paper(Accelerator::Grid),
        paper(Accelerator::Bvh),
        paper(Accelerator::None),
        match not {
            0 => "yes".into(),
            _ => format!("NO: {not} of {}", rows.len()),
        },
    ]
}

/// One line per case.
#[must_use]
pub fn text(outcomes: &[Outcome]) -> String {
    let mut lines = vec![SUMMARY.map(str::to_owned)];
    lines.extend(outcomes.iter().map(summary));
    let mut text = aligned(&lines, SUMMARY.len()).concat();
    for outcome in outcomes {
        for row in outcome.rows.iter().filter(|row| !row.is_as_expected()) {
            text += &format!("not as expected: {}\n", row.result());
        }
        if let Some(wrong_ray) = &outcome.first_wrong_ray {
            text += &format!("{wrong_ray}\n");
        }
    }
    text
}

/// A list of the cases.
#[must_use]
pub fn list(cases: &[&'static Case]) -> String {
    let header = ["case", "rays", "undecided limit", "paper must fail on (others may)", "what"];
    let mut lines = vec![header.map(str::to_owned)];
    for case in cases {
        let fails: Vec<&str> = case.paper.fails_on.iter().map(|a| a.name()).collect();
        lines.push([
            case.name.to_owned(),
            case.rays.to_string(),
            format!("{:.1}%", 100.0 * case.undecided.share),
            if fails.is_empty() { "-".into() } else { fails.join(",") },
            case.what.to_owned(),
        ]);
    }
    aligned(&lines, header.len()).concat()
}

/// What is known about a case's rays, as text.
pub(super) fn truth(case: &Case) -> &'static str {
    match case.truth {
        Truth::Open => "each ray is judged by what it may hit",
        Truth::Closed => "every ray hits something",
        Truth::Nothing => "no ray hits anything: every triangle is seen edge-on, or has no area",
    }
}
