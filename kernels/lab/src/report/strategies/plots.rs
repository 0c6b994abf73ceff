//! The plots of strategies.

use raystep_kernels::Accelerator;
use raystep_kernels::options::Strategy;

use super::super::page::number;
use super::super::work::Work;
use super::{STRUCTURES, of};
use crate::plots::{Axis, Dash, Plot, Scale, Series, Stroke};
use crate::tidy::Row;

/// A measure of error over the time of an image: every strategy with one structure, and mis with the others.
pub(super) fn over_time(rows: &[Row], first: Accelerator, column: &str) -> Plot {
    let series_of = |strategy: Strategy, structure: Accelerator| {
        let wanted = |row: &&Row| row.get("accelerator") == structure.name();
        let known = |row: &Row| {
            let ends = ["low", "high"].map(|end| row.number(&format!("{column}_{end}")));
            let point = (row.number("image_ns")? * 1e-9, row.number(column).filter(|&error| error > 0.0)?);
            Some((point, ends[0].zip(ends[1])))
        };
        let is_clear = |row: &&Row| row.get("is_fitted") == "true" || column != "error";
        of(rows, "convergence", strategy).filter(wanted).filter(is_clear).filter_map(known).unzip()
    };
    let mut series = Vec::new();
    for (color, &strategy) in Strategy::ALL.iter().enumerate() {
        let (points, whiskers): (Vec<_>, Vec<_>) = series_of(strategy, first);
        let whiskers = whiskers.into_iter().collect::<Option<Vec<_>>>().unwrap_or_default();
        series.push(Series { whiskers, ..Series::line(format!("{strategy}, {first}"), color, points) });
    }
    let others = STRUCTURES.into_iter().filter(|&structure| structure != first);
    for (structure, (color, dash)) in others.zip([(3, Dash::Dashed), (4, Dash::DashDot)]) {
        let (points, _): (Vec<_>, Vec<_>) = series_of(Strategy::Mis, structure);
        let name = format!("{}, {structure}", Strategy::Mis);
        series.push(Series { stroke: Stroke::Line(dash), ..Series::line(name, color, points) });
    }
    series.retain(|series| !series.points.is_empty());
    let own = rows.iter().find_map(|row| row.number("reference_rmse")).filter(|_| column == "error");
    let times = || series.iter().flat_map(|series| series.points.iter().map(|point| point.0));
    let ends = times().reduce(f64::min).zip(times().reduce(f64::max));
    if let Some((own, (begin, end))) = own.zip(ends) {
        let stroke = Stroke::Line(Dash::Dotted);
        series.push(Series { stroke, ..Series::dashed("the reference's own", 6, vec![(begin, own), (end, own)]) });
    }
    let (title, axis) = match column {
        "error" => ("Error over time, by strategy", "root mean square error, linear light"),
        _ => ("FLIP over time, by strategy", "mean of FLIP"),
    };
    Plot::new(title, Axis::new("time of the image, s", Scale::Log), Axis::new(axis, Scale::Log), series)
}

pub(super) fn caption(work: &Work<'_>, rows: &[Row], column: &str) -> String {
    let Some(row) = rows.iter().find(|row| row.get("quantity") == "median_error") else { return String::new() };
    let measure = match column {
        "error" => {
            "Root mean square error, without the reference's own (dotted) and where it is at least three times as large,"
        }
        _ => "Mean of FLIP (Andersson et al. 2020), which has a floor in the reference's own error,",
    };
    format!(
        "{measure} at 2, 4, 8… samples over the time of so many, of paths with up to {} bounces: medians over {} seeds with \
         95% intervals by order statistics, {} × {} pixels. Images do not depend on the structure. Times are {}.",
        number("max_depth", row),
        number("seeds", row),
        number("width_px", row),
        number("height_px", row),
        work.clock_in_words(),
    )
}
