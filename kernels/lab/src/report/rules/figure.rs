//! The diagram of the rules: what leaving out each saves, and how often it is wrong.

use super::ALL;
use crate::human::digits;
use crate::plots::precision::{Choice, Legend, Precision, Sign};
use crate::plots::{Axis, Mark, Scale};
use crate::structures::{STRUCTURES, color};
use crate::tidy::Row;

/// Rows that compare all strata together with robust numerics.
pub(super) fn compared_rows(rows: &[Row]) -> impl Iterator<Item = &Row> {
    rows.iter().filter(|row| row.get("stratum") == ALL && !row.get("ratio_to").is_empty())
}

/// A rule's name beside its structure.
fn name(row: &Row) -> String {
    let rule = if row.get("numerics") == "paper" { "all (paper)" } else { row.get("rule") };
    format!("{}: {rule}", row.get("accelerator"))
}

fn choice(row: &Row) -> Option<Choice> {
    let ends = |low: &str, high: &str| Some((row.number(low)?, row.number(high)?));
    Some(Choice {
        label: name(row),
        x: row.number("time_ratio")?,
        x_ends: ends("time_ratio_low", "time_ratio_high"),
        wrong: row.number("wrong_per_million")?,
        wrong_ends: ends("wrong_per_million_low", "wrong_per_million_high"),
        // Most are aimed where f32 cannot decide: in the table.
        undecided: 0.0,
        color: color(row.get("accelerator")),
        shape: Mark::Dot,
        is_hollow: row.get("numerics") == "paper",
        is_front: false,
        is_recommended: false,
    })
}

/// The diagram.
pub(super) fn of(rows: &[Row]) -> Precision {
    let mut choices: Vec<Choice> = compared_rows(rows).filter_map(choice).collect();
    choices.sort_by(|a, b| a.color.cmp(&b.color).then(a.x.total_cmp(&b.x)));
    let bound = |row: &Row| row.number("wrong_per_million_high").filter(|_| row.get("wrong_rays") == "0");
    let has = |(name, _): &(&str, usize)| compared_rows(rows).any(|row| row.get("accelerator") == *name);
    let sign = |(name, color): (&str, usize)| Sign {
        name: name.to_owned(),
        color: Some(color),
        shape: Mark::Dot,
        is_hollow: false,
    };
    let signs = STRUCTURES.into_iter().filter(has).map(sign).collect();
    Precision {
        title: "Without one rule, relative to robust".into(),
        x: Axis::new("ratio of times to robust", Scale::Ratio),
        y: Axis::new("wrong per million rays aimed at edges and cell faces", Scale::Log),
        at_most: compared_rows(rows).filter_map(bound).reduce(f64::max),
        legend: vec![Legend { heading: "structure".into(), signs }],
        from: Some(1.0),
        choices,
    }
}

/// What the diagram shows, of how many rays and runs.
pub(super) fn caption(rows: &[Row]) -> String {
    let most = |column: &str| compared_rows(rows).filter_map(|row| row.number(column)).fold(0.0, f64::max);
    let strata = rows.iter().filter(|row| row.get("stratum") != ALL).map(|row| row.get("stratum"));
    let mut names: Vec<String> = Vec::new();
    for name in strata.map(|name| name.replace('_', " ")) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    format!(
        "Schedule fused; exact-order relative to --order exact; {} rays from inside the scene, as many each at: {}. Median ratio of {} pairs of runs, 95% \
         interval. Wrong rays: exact 95% interval.",
        digits(most("judged_rays")),
        names.join(", "),
        digits(most("runs")),
    )
}
