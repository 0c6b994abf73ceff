//! The plots of offset and scale.

use crate::plots::{Axis, Mark, Plot, Scale, Series, Stroke};
use crate::tidy::Row;

fn axis_of(column: &str) -> Axis {
    let label = match column {
        "scale" => "scale of the scene",
        _ => "offset, in extents of the scene",
    };
    Axis::new(label, Scale::Log)
}

/// Points of the rows with robust numerics: one column over another.
fn points(rows: &[Row], x: &str, y: &str) -> Vec<(f64, f64)> {
    let of = rows.iter().filter(|r| r.get("numerics") == "robust");
    of.filter_map(|r| Some((r.number(x)?, r.number(y)?))).collect()
}

/// Errors divided by the bound of each ray. 1 is the bound; if nothing comes within a factor of ten of it, it is too
/// loose.
pub(super) fn by_bound(column: &str, rows: &[Row]) -> Plot {
    let of = |y: &str| points(rows, column, y);
    let mut series = vec![
        Series::line("arithmetic", 0, of("t_error_by_own_bound_largest")),
        Series::line("with rounding", 1, of("rounding_error_by_own_bound_largest")),
    ];
    let ends = of("t_error_by_own_bound_largest");
    for (name, color, at) in [("the bound", 6, 1.0), ("a tenth of it", 4, 0.1)] {
        series.push(Series::dashed(name, color, ends.iter().map(|p| (p.0, at)).collect()));
    }
    Plot {
        title: "Largest error of t relative to the same ray's bound, robust numerics".into(),
        x: axis_of(column),
        y: Axis::new("error relative to bound", Scale::Log),
        series,
        places: Vec::new(),
    }
}

/// Errors of t, and, over offsets, the predicted rounding error of the scene.
pub(super) fn errors(column: &str, rows: &[Row]) -> Plot {
    let points = |y: &str| points(rows, column, y);
    let mut series = Vec::new();
    for (color, name, of, which) in [
        (0, "arithmetic, largest", "t", "largest"),
        (4, "arithmetic, median", "t", "median"),
        (1, "with rounding, largest", "rounding", "largest"),
        (3, "with rounding, median", "rounding", "median"),
    ] {
        series.push(Series::line(name, color, points(&format!("{of}_error_extents_{which}"))));
        // Relative to the extent, the predicted rounding error is the same at every scale, so it is not plotted.
        if of == "rounding" && column != "scale" {
            let predicted = points(&format!("{of}_bound_extents_{which}"));
            series.push(Series::dashed(format!("predicted, {which}"), color, predicted));
        }
    }
    series.push(Series::dashed("one rounding of the depth", 6, points("t_step_extents_largest")));
    Plot {
        title: "Error of t along the ray, robust numerics".into(),
        x: axis_of(column),
        y: Axis::new("error, in extents of the scene", Scale::Log),
        series,
        places: Vec::new(),
    }
}

/// Rays with an error, by both numerics.
pub(super) fn lost(column: &str, rows: &[Row]) -> Plot {
    let mut series = Vec::new();
    for (color, numerics, mark) in [(0, "robust", Mark::Dot), (1, "paper", Mark::Triangle)] {
        for (what, name, stroke) in [("wrong", "wrong", Stroke::Solid), ("lost", "lost", Stroke::Dashed)] {
            let of: Vec<&Row> = rows.iter().filter(|r| r.get("numerics") == numerics).collect();
            let column_of = |end: &str| format!("{what}_per_million{end}");
            let points = of.iter().filter_map(|r| Some((r.number(column)?, r.number(&column_of(""))?))).collect();
            let ends = |r: &&Row| Some((r.number(&column_of("_low"))?, r.number(&column_of("_high"))?));
            let whiskers = if what == "wrong" { of.iter().filter_map(ends).collect() } else { Vec::new() };
            let mark = if what == "wrong" { mark } else { Mark::None };
            series.push(Series { name: format!("{numerics}: {name}"), points, whiskers, color, mark, stroke });
        }
    }
    Plot {
        title: "Wrong rays, and lost rays among them".into(),
        x: axis_of(column),
        y: Axis::new("rays per million", Scale::LogWithZero),
        series,
        places: Vec::new(),
    }
}
