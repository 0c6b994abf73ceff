//! The plots of grid resolutions and of structures.

use crate::human;
use crate::plots::{Axis, Bars, Plot, Scale, Series};
use crate::report::page::number;
use crate::tidy::Row;

fn grids(rows: &[Row]) -> impl Iterator<Item = &Row> {
    rows.iter().filter(|r| r.get("accelerator") == "grid")
}

fn over_cells<'a>(rows: impl Iterator<Item = &'a Row>, y: impl Fn(&Row) -> Option<f64>) -> Vec<(f64, f64)> {
    rows.filter_map(|r| Some((r.number("cells")?, y(r)?))).collect()
}

/// A plot over the number of cells, with whiskers if every point has an interval.
fn plot(rows: &[Row], title: &str, y: &str, color: usize, [middle, low, high]: [&str; 3], unit: f64) -> Plot {
    let points = over_cells(grids(rows), |r| Some(r.number(middle)? * unit));
    let ends = |r: &Row| Some((r.number(low)? * unit, r.number(high)? * unit)).filter(|_| low != middle);
    let whiskers: Option<Vec<_>> = grids(rows).filter(|r| r.number(middle).is_some()).map(ends).collect();
    let places = rows.iter().filter_map(|r| {
        let name = match (r.get("is_automatic"), r.get("is_selected")) {
            ("true", "true") => "automatic, selected",
            ("true", _) => "automatic",
            (_, "true") => "selected",
            _ => return None,
        };
        Some((r.number("cells")?, name.to_owned()))
    });
    let series = Series { whiskers: whiskers.unwrap_or_default(), ..Series::line("grid", color, points) };
    let [x, y] = ["cells of the grid", y].map(|label| Axis::new(label, Scale::Log));
    Plot { places: places.collect(), ..Plot::new(title, x, y, vec![series]) }
}

pub(super) fn times(rows: &[Row]) -> Plot {
    plot(rows, "Tracing the view, by resolution", "time, ms", 0, ["median_ns", "low_ns", "high_ns"], 1e-6)
}

pub(super) fn builds(rows: &[Row]) -> Plot {
    let columns = ["build_s", "build_s_low", "build_s_high"];
    plot(rows, "Planning and building on the CPU, by resolution", "time, ms", 1, columns, 1e3)
}

pub(super) fn bytes(rows: &[Row]) -> Plot {
    // No interval: a count.
    plot(rows, "Memory by resolution", "memory, KiB", 2, ["structure_bytes"; 3], 1.0 / 1024.0)
}

/// One bar for each structure.
fn bars(rows: &[Row], title: &str, color: usize, length_ms: impl Fn(&Row) -> Option<f64>) -> Bars {
    let is_shown = |r: &&Row| r.get("accelerator") != "grid" || r.get("is_automatic") == "true";
    let bar = |r: &Row| {
        let length = length_ms(r)?;
        Some((format!("{}, {}", r.get("accelerator"), human::time(1e6 * length)), vec![(length, color)]))
    };
    Bars {
        title: title.into(),
        x: "time, ms".into(),
        legend: Vec::new(),
        bars: rows.iter().filter(is_shown).filter_map(bar).collect(),
    }
}

pub(super) fn structure_times(rows: &[Row]) -> Bars {
    let view = rows.iter().find(|r| r.get("is_automatic") == "true").map(|r| r.get("rays").to_owned());
    // Times of fewer rays are not comparable.
    let whole =
        move |r: &Row| r.number("median_ns").filter(|_| view.as_deref() == Some(r.get("rays"))).map(|ns| ns / 1e6);
    bars(rows, "Tracing the view, by structure", 0, whole)
}

pub(super) fn structure_builds(rows: &[Row]) -> Bars {
    bars(rows, "Planning and building on the CPU, by structure", 1, |r| Some(r.number("build_s")? * 1e3))
}

fn automatic(rows: &[Row]) -> Option<&Row> {
    rows.iter().find(|r| r.get("is_automatic") == "true")
}

pub(super) fn times_caption(rows: &[Row]) -> String {
    let Some(row) = automatic(rows) else { return String::new() };
    format!(
        "Time to trace {} rays over the number of cells of the grid, with schedule compact and robust rules: medians of \
         {} interleaved runs; bars are 95% intervals of the median ({}).",
        number("rays", row),
        number("runs", row),
        row.get("interval_method").replace('_', " "),
    )
}

pub(super) fn structures_caption(rows: &[Row]) -> String {
    let Some(row) = automatic(rows) else { return String::new() };
    format!(
        "Time to trace {} rays with schedule compact and robust rules: bars are medians of {} interleaved runs. A structure \
         is missing if it was timed with fewer rays.",
        number("rays", row),
        number("runs", row),
    )
}

/// With `has_intervals`, the plot shows those that there are.
pub(super) fn builds_caption(rows: &[Row], has_intervals: bool) -> String {
    let Some(row) = automatic(rows) else { return String::new() };
    let what = if has_intervals { "" } else { "bars are " };
    let bars = match has_intervals && !row.get("build_s_low").is_empty() {
        true => "; bars are 95% intervals of the median",
        false => "",
    };
    format!(
        "Time to plan and build on the CPU, by its clock: {what}medians of {} builds, one structure after the other{bars}.",
        number("builds", row)
    )
}
