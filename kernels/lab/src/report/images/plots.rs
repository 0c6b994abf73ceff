//! Errors over the time of an image.

use crate::plots::{Axis, Plot, Scale, Series};
use crate::tidy::Row;

/// A point with its ends.
pub(in super::super) type Known = ((f64, f64), Option<(f64, f64)>);

/// What is known of rows as a line, with whiskers if every point has ends.
pub(in super::super) fn line(name: String, color: usize, known: impl Iterator<Item = Known>) -> Series {
    let (points, whiskers): (Vec<_>, Vec<_>) = known.unzip();
    let whiskers = whiskers.into_iter().collect::<Option<Vec<_>>>().unwrap_or_default();
    Series { whiskers, ..Series::line(name, color, points) }
}

pub(in super::super) fn seconds(row: &Row) -> Option<f64> {
    Some(row.number("image_ns")? * 1e-9)
}

/// The ends of a column's interval.
pub(in super::super) fn ends(row: &Row, column: &str) -> Option<(f64, f64)> {
    row.number(&format!("{column}_low")).zip(row.number(&format!("{column}_high")))
}

/// A measure of error of these rows; where the reference's own may be a large part of it, it is left out.
pub(in super::super) fn measure<'a>(
    name: String,
    color: usize,
    rows: impl Iterator<Item = &'a Row>,
    column: &str,
) -> Series {
    let known =
        |row: &Row| Some(((seconds(row)?, row.number(column).filter(|&error| error > 0.0)?), ends(row, column)));
    let is_clear = |row: &&Row| row.get("is_fitted") == "true" || column != "error";
    line(name, color, rows.filter(is_clear).filter_map(known))
}

pub(in super::super) fn over_time(title: String, axis: &str, series: Vec<Series>) -> Plot {
    Plot::new(title, Axis::new("time of the image, s", Scale::Log), Axis::new(axis, Scale::Log), series)
}

/// The plot of a measure of error.
pub(in super::super) fn of_measure(what: &str, column: &str, series: Vec<Series>) -> Plot {
    let (name, axis) = match column {
        "error" => ("Error", "root mean square error, linear light"),
        _ => ("FLIP", "mean of FLIP"),
    };
    over_time(format!("{name} over time, {what}"), axis, series)
}
