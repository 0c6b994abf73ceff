//! The plots of resolved rays.

use crate::plots::{Axis, Dash, Mark, Plot, Scale, Series, Stroke};
use crate::report::page::number;
use crate::structures::STRUCTURES;
use crate::tidy::Row;

/// Schedules and numerics, with their colours and dashes.
const LINES: [(&str, &str, usize, Dash); 6] = [
    ("first", "robust", 0, Dash::Solid),
    ("second", "robust", 4, Dash::DashDot),
    ("compact", "robust", 2, Dash::Dashed),
    ("fused", "robust", 3, Dash::Solid),
    ("first", "paper", 1, Dash::Dotted),
    ("second", "paper", 1, Dash::Dashed),
];

/// Milliseconds from the first to the last pass of all configurations: the time axis of all plots. The left end is half
/// the earliest time, so that a curve's first step is seen.
fn range(rows: &[Row]) -> Option<[f64; 2]> {
    let times = rows.iter().filter_map(|r| r.number("pass_end_ns")).filter(|&ns| ns > 0.0).map(|ns| ns / 1e6);
    let (low, high) = times.fold((f64::INFINITY, 0.0), |(l, h), t| (f64::min(l, t), f64::max(h, t)));
    (low <= high).then_some([0.5 * low, high])
}

/// Makes the time axis the same in all plots, and draws nothing.
fn same_axis([low, high]: [f64; 2], y: f64) -> Series {
    Series { mark: Mark::None, stroke: Stroke::None, ..Series::line("", 6, vec![(low, y), (high, y)]) }
}

fn rows_of<'a>(rows: &'a [Row], wanted: &[(&str, &str)]) -> Vec<&'a Row> {
    rows.iter().filter(|r| r.is(wanted)).collect()
}

/// The curve of a configuration: 0 from the left end until the first pass that changes it.
fn curve(rows: &[&Row], begin: f64, y: impl Fn(&Row) -> Option<f64>) -> Vec<(f64, f64)> {
    let points = rows.iter().filter_map(|r| Some((r.number("pass_end_ns")? / 1e6, y(r)?)));
    let points: Vec<_> = points.collect();
    if points.is_empty() { points } else { std::iter::once((begin, 0.0)).chain(points).collect() }
}

/// The last row of a configuration, if it is wrong more often than the best one.
fn is_worse<'a>(rows: &[&'a Row], all: &[Row]) -> Option<&'a Row> {
    let wrong = |r: &Row| r.number("resolved_wrong_per_million");
    let best = all.iter().filter(|r| r.get("is_last") == "true").filter_map(wrong).fold(f64::INFINITY, f64::min);
    rows.iter().find(|r| r.get("is_last") == "true" && wrong(r).is_some_and(|w| w > best)).copied()
}

pub(super) fn resolved(accelerator: &str, rows: &[Row]) -> Plot {
    let share = |r: &Row| Some(100.0 * r.number("resolved_rays")? / r.number("rays").filter(|&n| n > 0.0)?);
    let range = range(rows);
    let mut series = Vec::new();
    for (schedule, numerics, color, dash) in LINES {
        let of = rows_of(rows, &[("accelerator", accelerator), ("schedule", schedule), ("numerics", numerics)]);
        let points = curve(&of, range.map_or(0.0, |r| r[0]), share);
        let Some(&last) = points.last() else { continue };
        let mut name = if numerics == "paper" { format!("{schedule}, paper") } else { schedule.to_owned() };
        if let Some(row) = is_worse(&of, rows) {
            name += &format!(": {} wrong", row.get("resolved_wrong_rays"));
            // The end of a curve that is not comparable is marked.
            series.push(Series { stroke: Stroke::None, mark: Mark::Triangle, ..Series::line("", color, vec![last]) });
        }
        // `fused` resolves all rays in one pass; it does not matter that it shades them afterwards.
        series.push(match schedule {
            "fused" => {
                let points = points.into_iter().filter(|p| p.1 > 0.0).take(1).collect();
                Series { stroke: Stroke::None, ..Series::line(name, color, points) }
            }
            _ => Series { mark: Mark::None, stroke: Stroke::Steps(dash), ..Series::line(name, color, points) },
        });
    }
    // Nothing is drawn for a structure without curves.
    series.extend(range.filter(|_| !series.is_empty()).map(|range| same_axis(range, 100.0)));
    Plot::new(
        format!("Rays finished over time, {accelerator}"),
        Axis::new("time since the start of the first pass, ms", Scale::Log),
        Axis::new("rays with a final hit, %", Scale::Linear),
        series,
    )
}

pub(super) fn wrong(rows: &[Row]) -> Plot {
    let wrong = |r: &Row| r.number("resolved_wrong_per_million");
    let range = range(rows);
    let mut series = Vec::new();
    for (accelerator, color) in STRUCTURES {
        let lines =
            [("paper", "first", Dash::Solid), ("paper", "second", Dash::DashDot), ("robust", "compact", Dash::Dotted)];
        for (numerics, schedule, dash) in lines {
            let of = rows_of(rows, &[("accelerator", accelerator), ("schedule", schedule), ("numerics", numerics)]);
            let points = curve(&of, range.map_or(0.0, |r| r[0]), wrong);
            let name = format!("{accelerator} {schedule}, {numerics}");
            if !points.is_empty() {
                series.push(Series { stroke: Stroke::Steps(dash), ..Series::line(name, color, points) });
            }
        }
    }
    series.extend(range.map(|range| same_axis(range, 0.0)));
    Plot::new(
        "Rays with a wrong final hit",
        Axis::new("time since the start of the first pass, ms", Scale::Log),
        Axis::new("wrong per million judged", Scale::LogWithZero),
        series,
    )
}

pub(super) fn resolved_caption(accelerator: &str, rows: &[Row]) -> String {
    let Some(row) = rows.iter().find(|r| r.get("accelerator") == accelerator) else { return String::new() };
    format!(
        "Share of {} rays with a final hit at the end of each pass: the median of three runs. Fused is one pass, so one \
         mark. A triangle marks a curve with more wrong rays, of {} judged, than the best one; its time cannot be compared.",
        number("rays", row),
        number("judged_rays", row)
    )
}

pub(super) fn wrong_caption(rows: &[Row]) -> String {
    let Some(row) = rows.first() else { return String::new() };
    format!(
        "Rays whose final hit is wrong, at the end of each pass, per million of {} judged: all of the view, or a sample of it.",
        number("judged_rays", row)
    )
}

#[cfg(test)]
mod tests {
    use super::super::COLUMNS;
    use super::*;

    fn row(schedule: &str, numerics: &str, end_ms: f64, wrong: u32) -> Row {
        let row = Row::new(COLUMNS).set("accelerator", "grid").set("schedule", schedule).set("numerics", numerics);
        let row = row.set("pass_end_ns", 1e6 * end_ms).set("rays", 100u32).set("resolved_rays", 100u32);
        row.set("is_last", true).set("resolved_wrong_rays", wrong).set("resolved_wrong_per_million", wrong)
    }

    #[test]
    fn curves_share_an_axis_from_before_the_first_pass_and_wrong_ones_are_marked() {
        let rows = [row("compact", "robust", 2.0, 0), row("second", "paper", 50.0, 13)];
        let plot = resolved("grid", &rows);
        let of = |name: &str| plot.panels[0].series.iter().find(|s| s.name == name).expect("a curve");
        assert_eq!(of("compact").points, [(1.0, 0.0), (2.0, 100.0)]);
        assert_eq!(of("second, paper: 13 wrong").points, [(1.0, 0.0), (50.0, 100.0)]);
        assert_eq!(plot.panels[0].series.iter().filter(|s| s.mark == Mark::Triangle).count(), 1);
        // A structure that is not there has no plot.
        assert!(resolved("bvh", &rows).panels[0].series.is_empty());
    }
}
