//! The plots of offset and scale.

use crate::commands::report::plot::{Axis, Mark, Plot, Scale, Series, Stroke};
use crate::commands::report::table::Row;

fn axis_of(column: &str) -> Axis {
    let label = match column {
        "scale" => "scale of the scene".into(),
        _ => "distance from where it was, in extents of the scene".into(),
    };
    Axis { label, scale: Scale::Log }
}

/// Errors of t, with what is predicted of them.
pub(super) fn errors(column: &str, rows: &[Row]) -> Plot {
    let points = |y: &str| {
        let of = rows.iter().filter(|r| r.get("numerics") == "robust");
        of.filter_map(|r| Some((r.number(column)?, r.number(y)?))).collect::<Vec<_>>()
    };
    let mut series = Vec::new();
    for (color, name, of, which) in [
        (0, "arithmetic, largest", "t", "largest"),
        (4, "arithmetic, median", "t", "median"),
        (1, "with rounding, largest", "rounding", "largest"),
        (3, "with rounding, median", "rounding", "median"),
    ] {
        series.push(Series::line(name, color, points(&format!("{of}_error_extents_{which}"))));
        let predicted = points(&format!("{of}_bound_extents_{which}"));
        series.push(Series::dashed(format!("bound, {which}"), color, predicted));
    }
    // One entry in the legend for each colour's prediction.
    for s in series.iter_mut().filter(|s| s.stroke == Stroke::Dashed) {
        s.name = if s.color == 0 { "bounds of the same colour".into() } else { String::new() };
    }
    series.push(Series::dashed("bound of the worst ray", 5, points("t_bound_extents_of_largest_error")));
    series.push(Series::dashed("one rounding of the depth", 6, points("t_step_extents_largest")));
    Plot {
        title: "Error of t along the ray, robust rules".into(),
        x: axis_of(column),
        y: Axis { label: "error, in extents of the scene".into(), scale: Scale::Log },
        series,
        places: Vec::new(),
    }
}

/// Rays with an error, by both rules.
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
        title: "Rays that are wrong, and those of them that are lost".into(),
        x: axis_of(column),
        y: Axis { label: "rays per million".into(), scale: Scale::LogWithZero },
        series,
        places: Vec::new(),
    }
}
