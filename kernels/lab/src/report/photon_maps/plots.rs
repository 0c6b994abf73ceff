//! The plots of photon maps.

use super::super::images::plots::{self, ends, line, measure, of_measure, seconds};
use super::super::page::number;
use super::super::work::Work;
use super::{Way, of};
use crate::plots::{Dash, Plot, Series, Stroke};
use crate::tidy::Row;

/// A measure of error over the time of an image, for every way.
pub(super) fn over_time(ways: &[Way], rows: &[Row], column: &str) -> Plot {
    let of_way = |(color, way): (usize, &Way)| measure(way.name.clone(), color, of(rows, way), column);
    let mut series: Vec<Series> = ways.iter().enumerate().map(of_way).collect();
    series.retain(|series| !series.points.is_empty());
    of_measure("paths and photons", column, series)
}

/// Bias and standard deviation over the time of an image: where the bias's interval has 0, it is not drawn.
pub(super) fn apart(ways: &[Way], rows: &[Row]) -> Plot {
    let mut series = Vec::new();
    for (color, way) in ways.iter().enumerate() {
        let bias = |row: &Row| {
            let squared = row.number("bias_squared")?;
            let (low, high) = ends(row, "bias_squared").filter(|&(low, _)| low > 0.0)?;
            Some(((seconds(row)?, squared.sqrt()), Some((low.sqrt(), high.sqrt()))))
        };
        let deviation = |row: &Row| Some(((seconds(row)?, row.number("variance").filter(|&v| v > 0.0)?.sqrt()), None));
        series.push(line(format!("{}: bias", way.name), color, of(rows, way).filter_map(bias)));
        let name = format!("{}: standard deviation", way.name);
        let deviation = line(name, color, of(rows, way).filter_map(deviation));
        series.push(Series { stroke: Stroke::Line(Dash::Dashed), ..deviation });
    }
    series.retain(|series| !series.points.is_empty());
    plots::over_time("Bias and deviation over time".into(), "root mean square over pixels, linear light", series)
}

pub(super) fn caption(work: &Work<'_>, rows: &[Row], column: &str) -> String {
    let Some(row) = rows.iter().find(|row| row.get("quantity") == "convergence") else { return String::new() };
    let measure = match column {
        "error" => "Root mean square error, without the reference's own and where it is at least three times as large,",
        "flip" => "Mean of FLIP (Andersson et al. 2020), which has a floor in the reference's own error,",
        _ => {
            "Bias, where its 95% interval by the jackknife (Tukey 1958) is above 0, and standard deviation of one image \
             (dashed),"
        }
    };
    let over = match column {
        "bias_squared" => "over",
        _ => "medians with 95% intervals by order statistics over",
    };
    format!(
        "{measure} at 2, 4, 8… samples over the time of so many, up to {} bounces: {over} {} seeds, {} × {} pixels. The \
         reference is along paths. Times are {}.",
        number("max_depth", row),
        number("seeds", row),
        number("width_px", row),
        number("height_px", row),
        work.clock_in_words(),
    )
}
