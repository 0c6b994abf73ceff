//! The work–precision diagram of the choices.

use crate::human::digits;
use crate::plots::precision::{Choice, Legend, Precision, Sign};
use crate::plots::{Axis, Mark, Scale};
use crate::structures::{STRUCTURES, color};
use crate::tidy::Row;

/// Colour of other programs' methods.
const OWN: usize = 3;

fn shape(schedule: &str) -> Mark {
    match schedule {
        "fused" => Mark::Dot,
        "compact" => Mark::Square,
        "second" => Mark::Triangle,
        _ => Mark::Down,
    }
}

fn choice(row: &Row) -> Option<Choice> {
    let (accelerator, schedule, numerics) = (row.get("accelerator"), row.get("schedule"), row.get("numerics"));
    let ends = |low: &str, high: &str| Some((row.number(low)?, row.number(high)?));
    let is_own = !row.get("method").is_empty();
    Some(Choice {
        label: if is_own {
            row.get("method").to_owned()
        } else {
            format!("{accelerator}, {schedule}{}", if numerics == "paper" { ", paper" } else { "" })
        },
        x: row.number("ns_per_ray")?,
        x_ends: ends("ns_per_ray_low", "ns_per_ray_high"),
        wrong: row.number("wrong_per_million")?,
        wrong_ends: ends("wrong_per_million_low", "wrong_per_million_high"),
        undecided: row.number("undecided_per_million").unwrap_or(0.0),
        color: if is_own { OWN } else { color(accelerator) },
        shape: if is_own { Mark::Dot } else { shape(schedule) },
        is_hollow: numerics == "paper",
        is_front: row.get("is_front") == "true",
        is_recommended: row.get("is_recommended") == "true",
    })
}

/// The most choices in a diagram: more than raystep has, so that only other programs' methods can be too many.
const MOST: usize = 60;

/// The rows that are drawn: all, or the recommended one, those that no other beats, and the fastest of the rest.
fn shown(rows: &[Row]) -> impl Iterator<Item = &Row> {
    let mut rows: Vec<&Row> = rows.iter().filter(|row| choice(row).is_some()).collect();
    let time = |row: &Row| row.number("ns_per_ray").unwrap_or(f64::INFINITY);
    rows.sort_by(|a, b| {
        let is_beaten = |row: &Row| ["is_front", "is_recommended"].iter().all(|column| row.get(column) != "true");
        is_beaten(a).cmp(&is_beaten(b)).then(time(a).total_cmp(&time(b)))
    });
    rows.into_iter().take(MOST)
}

/// What colours, shapes and fillings stand for.
fn legend(rows: &[Row]) -> Vec<Legend> {
    let has = |column: &str, value: &str| rows.iter().any(|row| row.get(column) == value);
    let sign = |name: &str, color, shape, is_hollow| Sign { name: name.to_owned(), color, shape, is_hollow };
    let structures = STRUCTURES.into_iter().filter(|(name, _)| has("accelerator", name));
    let own = rows.iter().any(|row| !row.get("method").is_empty()).then_some(("other program", OWN));
    let schedules = ["first", "second", "compact", "fused"].into_iter().filter(|name| has("schedule", name));
    // Without the paper's rules there is one filling, which needs no name.
    let rules = [("robust", false), ("paper", true)].into_iter();
    let rules = rules.filter(|(name, _)| has("numerics", "paper") && has("numerics", name));
    let group = |heading: &str, signs: Vec<Sign>| Legend { heading: heading.to_owned(), signs };
    vec![
        group("structure", structures.chain(own).map(|(name, of)| sign(name, Some(of), Mark::Dot, false)).collect()),
        group("schedule", schedules.map(|name| sign(name, None, shape(name), false)).collect()),
        group("rules", rules.map(|(name, is_hollow)| sign(name, None, Mark::Dot, is_hollow)).collect()),
    ]
}

/// The diagram, of rays from a file or of the view.
pub(super) fn of(rows: &[Row], is_file: bool) -> Precision {
    let mut choices: Vec<Choice> = shown(rows).filter_map(choice).collect();
    choices.sort_by(|a, b| a.x.total_cmp(&b.x));
    let bound_of_none = |row: &Row| row.number("wrong_per_million_high").filter(|_| row.get("wrong_rays") == "0");
    Precision {
        title: "Time against wrong rays".into(),
        x: Axis::new("time per ray, ns", Scale::Log),
        y: Axis::new(format!("wrong per million rays of the {}", if is_file { "file" } else { "view" }), Scale::Log),
        at_most: rows.iter().filter_map(bound_of_none).reduce(f64::max),
        legend: legend(rows),
        from: None,
        choices,
    }
}

/// What the diagram shows, of how many rays and runs.
pub(super) fn caption(rows: &[Row], is_file: bool) -> String {
    let ends = |column: &str| {
        let values = || rows.iter().filter_map(|r| r.number(column));
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        if low < high { format!("{} to {}", digits(low), digits(high)) } else { digits(high) }
    };
    let mut methods: Vec<&str> = rows.iter().map(|r| r.get("interval_method")).filter(|m| !m.is_empty()).collect();
    methods.sort_unstable();
    methods.dedup();
    let method = methods.join(" or ").replace('_', " ");
    let mut caption = format!(
        "Median of {} interleaved runs, 95% interval ({}). Wrong of {} judged rays, exact 95% interval.",
        ends("runs"),
        if method.is_empty() { "none: too few runs" } else { &method },
        ends("judged_rays"),
    );
    let shown: Vec<&Row> = shown(rows).collect();
    let is_drawn = |of: fn(&Choice) -> bool| shown.iter().filter_map(|row| choice(row)).filter(of).count();
    let mut explain = |is_drawn: bool, what: &str| {
        if is_drawn {
            caption += what
        }
    };
    explain(is_drawn(|c| c.undecided > 0.0) > 0, " Pale: undecided rays.");
    // Of a single choice there is no line.
    explain(is_drawn(|c| c.is_front) > 1, " Dashed line: choices that no other choice beats in both time and errors.");
    explain(is_file, " Rays from a file, taken as a random sample.");
    let slower = rows.iter().filter_map(choice).count() - shown.len();
    explain(slower > 0, &format!(" Not drawn: the {slower} slowest of the others."));
    caption
}
