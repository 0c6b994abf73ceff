//! The plots of strategies.

use raystep_kernels::Accelerator;
use raystep_kernels::options::Strategy;

use super::super::images::plots::{measure, of_measure};
use super::super::page::number;
use super::super::work::Work;
use super::{STRUCTURES, of};
use crate::plots::{Dash, Plot, Series, Stroke};
use crate::tidy::Row;

/// A measure of error over the time of an image: every strategy with one structure, and mis with the others.
pub(super) fn over_time(rows: &[Row], first: Accelerator, column: &str) -> Plot {
    let line = |strategy: Strategy, structure: Accelerator, color| {
        let rows = of(rows, "convergence", strategy).filter(|row| row.get("accelerator") == structure.name());
        measure(format!("{strategy}, {structure}"), color, rows, column)
    };
    let strategies = Strategy::ALL.iter().enumerate();
    let mut series: Vec<Series> = strategies.map(|(color, &strategy)| line(strategy, first, color)).collect();
    let others = STRUCTURES.into_iter().filter(|&structure| structure != first);
    for (structure, (color, dash)) in others.zip([(3, Dash::Dashed), (4, Dash::DashDot)]) {
        let line = line(Strategy::Mis, structure, color);
        series.push(Series { stroke: Stroke::Line(dash), whiskers: Vec::new(), ..line });
    }
    series.retain(|series| !series.points.is_empty());
    let own = rows.iter().find_map(|row| row.number("reference_rmse")).filter(|_| column == "error");
    let times = || series.iter().flat_map(|series| series.points.iter().map(|point| point.0));
    let ends = times().reduce(f64::min).zip(times().reduce(f64::max));
    if let Some((own, (begin, end))) = own.zip(ends) {
        let stroke = Stroke::Line(Dash::Dotted);
        series.push(Series { stroke, ..Series::dashed("the reference's own", 6, vec![(begin, own), (end, own)]) });
    }
    of_measure("by strategy", column, series)
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
