//! The plots of photon maps.

use super::super::page::number;
use super::super::work::Work;
use super::{Way, of};
use crate::plots::{Axis, Dash, Plot, Scale, Series, Stroke};
use crate::tidy::Row;

const TIME: &str = "time of the image, s";

/// A point with its ends.
type Known = ((f64, f64), Option<(f64, f64)>);

/// What is known of every row over the time of its image, as a line.
fn line(name: String, color: usize, known: impl Iterator<Item = Known>) -> Series {
    let (points, whiskers): (Vec<_>, Vec<_>) = known.unzip();
    let whiskers = whiskers.into_iter().collect::<Option<Vec<_>>>().unwrap_or_default();
    Series { whiskers, ..Series::line(name, color, points) }
}

fn seconds(row: &Row) -> Option<f64> {
    Some(row.number("image_ns")? * 1e-9)
}

/// The ends of a column's interval.
fn ends(row: &Row, column: &str) -> Option<(f64, f64)> {
    row.number(&format!("{column}_low")).zip(row.number(&format!("{column}_high")))
}

/// A measure of error over the time of an image, for every way.
pub(super) fn over_time(ways: &[Way], rows: &[Row], column: &str) -> Plot {
    let is_clear = |row: &&Row| row.get("is_fitted") == "true" || column != "error";
    let known =
        |row: &Row| Some(((seconds(row)?, row.number(column).filter(|&error| error > 0.0)?), ends(row, column)));
    let of_way =
        |(color, way): (usize, &Way)| line(way.name.clone(), color, of(rows, way).filter(is_clear).filter_map(known));
    let mut series: Vec<Series> = ways.iter().enumerate().map(of_way).collect();
    series.retain(|series| !series.points.is_empty());
    let (title, axis) = match column {
        "error" => ("Error over time, paths and photons", "root mean square error, linear light"),
        _ => ("FLIP over time, paths and photons", "mean of FLIP"),
    };
    Plot::new(title, Axis::new(TIME, Scale::Log), Axis::new(axis, Scale::Log), series)
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
    let axis = Axis::new("root mean square over pixels, linear light", Scale::Log);
    Plot::new("Bias and deviation over time", Axis::new(TIME, Scale::Log), axis, series)
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
