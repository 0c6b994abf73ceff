//! The plots of offset and scale.

use crate::plots::{Axis, Dash, Plot, Scale, Series, Stroke};
use crate::tidy::Row;

fn axis_of(column: &str) -> Axis {
    let label = match column {
        "scale" => "scale of the scene",
        _ => "offset, in extents of the scene",
    };
    Axis::new(label, Scale::Log)
}

/// Points of rays in random directions with robust numerics: one column over another.
fn points(rows: &[Row], x: &str, y: &str) -> Vec<(f64, f64)> {
    let of = rows.iter().filter(|r| r.is(&[("numerics", "robust"), ("stratum", "anywhere")]));
    of.filter_map(|r| Some((r.number(x)?, r.number(y)?))).collect()
}

/// Errors divided by the bound of each ray. 1 is the bound; if nothing comes within a factor of ten of it, it is too
/// loose.
pub(super) fn by_bound(column: &str, rows: &[Row]) -> Plot {
    let of = |y: &str| points(rows, column, y);
    let mut series = vec![
        Series::line("arithmetic", 0, of("arithmetic_error_by_bound_largest")),
        Series::line("forward", 1, of("forward_error_by_bound_largest")),
    ];
    let ends = of("arithmetic_error_by_bound_largest");
    for (name, dash, at) in [("the bound", Dash::Dashed, 1.0), ("tenth (below: too loose)", Dash::Dotted, 0.1)] {
        let line = Series::dashed(name, 6, ends.iter().map(|p| (p.0, at)).collect());
        series.push(Series { stroke: Stroke::Line(dash), ..line });
    }
    Plot::new(
        "Largest error of t relative to the same ray's bound",
        axis_of(column),
        Axis::new("error relative to bound", Scale::Log),
        series,
    )
}

/// Errors of t, and, over offsets, the predicted forward error.
pub(super) fn errors(column: &str, rows: &[Row]) -> Plot {
    let points = |y: &str| points(rows, column, y);
    let mut series = Vec::new();
    for (color, of, which) in
        [(0, "arithmetic", "largest"), (4, "arithmetic", "median"), (1, "forward", "largest"), (3, "forward", "median")]
    {
        series.push(Series::line(format!("{of}, {which}"), color, points(&format!("{of}_error_extents_{which}"))));
        // Relative to the extent, the prediction is the same at every scale, so it is not plotted.
        if of == "forward" && column != "scale" {
            let predicted = points(&format!("{of}_bound_extents_{which}"));
            let dash = if which == "largest" { Dash::DashDot } else { Dash::Dotted };
            let line = Series::dashed(format!("forward bound, {which}"), color, predicted);
            series.push(Series { stroke: Stroke::Line(dash), ..line });
        }
    }
    series.push(Series::dashed("one rounding of the depth", 6, points("depth_rounding_extents_largest")));
    Plot::new(
        "Error of t along the ray",
        axis_of(column),
        Axis::new("error, in extents of the scene", Scale::Log),
        series,
    )
}

/// A count per million over places, with its interval if anything was counted.
fn per_million(column: &str, count: &str, rows: &[&Row], series: Series) -> Series {
    let name = |end: &str| format!("{count}_per_million{end}");
    let points = rows.iter().filter_map(|r| Some((r.number(column)?, r.number(&name(""))?))).collect();
    let ends = |r: &&Row| match r.number(&name(""))? {
        0.0 => Some((0.0, 0.0)),
        _ => Some((r.number(&name("_low"))?, r.number(&name("_high"))?)),
    };
    Series { points, whiskers: rows.iter().filter_map(ends).collect(), ..series }
}

/// Colour, stratum, and its name in the legend.
const STRATA: [(usize, &str, &str); 4] = [
    (1, "corners", "corners"),
    (3, "edge_middles", "middles of edges"),
    (5, "along_edges", "along edges"),
    (0, "anywhere", "any direction"),
];

/// The rows of a stratum with a set of rules.
fn of_stratum<'a>(rows: &'a [Row], numerics: &str, stratum: &str) -> Vec<&'a Row> {
    rows.iter().filter(|r| r.is(&[("numerics", numerics), ("stratum", stratum)])).collect()
}

fn has_wrong(rows: &[&Row]) -> bool {
    rows.iter().any(|r| r.number("wrong_per_million").is_some_and(|n| n > 0.0))
}

/// The names of the sets of rules and strata that [`wrong`] does not draw, as no ray is wrong anywhere.
pub(super) fn without_wrong(rows: &[Row]) -> Vec<String> {
    let name = |numerics: &str| {
        let of = |stratum: &str| of_stratum(rows, numerics, stratum);
        let none = STRATA.iter().filter(|(_, stratum, _)| !of(stratum).is_empty() && !has_wrong(&of(stratum)));
        let none: Vec<&str> = none.map(|(_, _, words)| *words).collect();
        (!none.is_empty()).then(|| format!("{numerics} ({})", none.join(", ")))
    };
    ["paper", "robust"].into_iter().filter_map(name).collect()
}

/// Wrong rays of both sets of rules, a line for each stratum in which any ray is wrong. The truth is the rounded scene.
pub(super) fn wrong(column: &str, rows: &[Row]) -> Plot {
    let mut series = Vec::new();
    for (numerics, dash) in [("paper", Dash::Solid), ("robust", Dash::Dotted)] {
        for (color, stratum, words) in STRATA {
            let of = of_stratum(rows, numerics, stratum);
            if has_wrong(&of) {
                let line = Series::line(format!("{numerics}: {words}"), color, Vec::new());
                series.push(per_million(column, "wrong", &of, Series { stroke: Stroke::Line(dash), ..line }));
            }
        }
    }
    series.push(bound_of_none(column, "wrong", "95% bound, no ray wrong", rows));
    Plot::new(
        "Wrong rays, compared with the rounded scene",
        axis_of(column),
        Axis::new("wrong rays per million", Scale::LogWithZero),
        series,
    )
}

/// The upper bound where nothing was counted: the same for all series, so it is one line instead of many bars.
fn bound_of_none(column: &str, count: &str, name: &str, rows: &[Row]) -> Series {
    let is_none = |r: &&Row| r.number(&format!("{count}_per_million")) == Some(0.0);
    let bound = |r: &Row| Some((r.number(column)?, r.number(&format!("{count}_per_million_high"))?));
    let mut points: Vec<(f64, f64)> = rows.iter().filter(is_none).filter_map(bound).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    points.dedup_by_key(|point| point.0);
    Series::dashed(name, 6, points)
}

/// Rays that hit something else than before the scene was rounded.
pub(super) fn changed(column: &str, rows: &[Row]) -> Plot {
    let of = |(numerics, color): (&str, usize)| {
        let of: Vec<&Row> = rows.iter().filter(|r| r.is(&[("numerics", numerics), ("stratum", "anywhere")])).collect();
        per_million(column, "changed", &of, Series::line(numerics, color, Vec::new()))
    };
    let mut series: Vec<Series> = [("robust", 0), ("paper", 1)].map(of).into();
    series.push(bound_of_none(column, "changed", "95% bound, no hit differs", rows));
    Plot::new(
        "Hits that differ from those before rounding",
        axis_of(column),
        Axis::new("differing hits per million rays", Scale::LogWithZero),
        series,
    )
}
