//! The plots of samples.

use raystep_kernels::Sampler;

use super::super::page::number;
use super::slopes::{Of, of_quantity};
use crate::human;
use crate::plots::{Axis, Dash, Plot, Scale, Series, Stroke};
use crate::tidy::Row;

const SAMPLERS: [(usize, Sampler); 2] = [(0, Sampler::Sobol), (1, Sampler::Random)];

/// x and y, or two ends.
type Point = (f64, f64);

fn medians(rows: &[Row], sampler: Sampler, of: Of) -> Vec<&Row> {
    let wanted = [("sampler", sampler.name()), ("pixels", of.name())];
    of_quantity(rows, "median_error").filter(|row| row.is(&wanted)).collect()
}

/// Points of a column over samples, with the ends of their intervals if all of them have one.
fn over_samples(rows: &[&Row], column: &str) -> (Vec<Point>, Vec<Point>) {
    let known: Vec<_> = rows.iter().filter_map(|r| Some((r, (r.number("samples")?, r.number(column)?)))).collect();
    let ends = |end: &str, row: &Row| row.number(&format!("{column}_{end}"));
    let whiskers: Option<Vec<_>> = known.iter().map(|(r, _)| Some((ends("low", r)?, ends("high", r)?))).collect();
    (known.into_iter().map(|(_, point)| point).collect(), whiskers.unwrap_or_default())
}

pub(super) fn errors(of: Of, rows: &[Row]) -> Plot {
    let mut series = Vec::new();
    for (color, sampler) in SAMPLERS {
        let medians: Vec<&Row> =
            medians(rows, sampler, of).into_iter().filter(|r| r.get("is_fitted") == "true").collect();
        let (points, whiskers) = over_samples(&medians, "error");
        let wanted = [("sampler", sampler.name()), ("pixels", of.name())];
        let slope = of_quantity(rows, "median_slope").find(|row| row.is(&wanted));
        let line = slope.and_then(|row| Some((row, through_middle(&points, row.number("slope")?)?)));
        series.push(Series { whiskers, stroke: Stroke::None, ..Series::line(sampler.name(), color, points) });
        if let Some((row, ends)) = line {
            let slope = human::field("slope", row.get("slope"));
            let stroke = Stroke::Line(if sampler == Sampler::Sobol { Dash::Dashed } else { Dash::DashDot });
            series.push(Series { stroke, ..Series::dashed(format!("{sampler}: slope {slope}"), color, ends) });
        }
    }
    let of_pixels: Vec<&Row> = of_quantity(rows, "median_error").filter(|r| r.get("pixels") == of.name()).collect();
    let own = of_pixels.iter().find_map(|r| r.number("reference_rmse"));
    let samples: Vec<f64> = of_pixels.iter().filter_map(|r| r.number("samples")).collect();
    if let (Some(own), [first, .., last]) = (own, &samples[..]) {
        let stroke = Stroke::Line(Dash::Dotted);
        series.push(Series { stroke, ..Series::dashed("the reference's own", 6, vec![(*first, own), (*last, own)]) });
    }
    Plot::new(
        format!("Error of the image, {}", of.words()),
        Axis::new("samples per pixel", Scale::Log),
        Axis::new("root mean square error, linear light", Scale::Log),
        series,
    )
}

/// A line of this slope through the middle of points, between their ends.
fn through_middle(points: &[(f64, f64)], slope: f64) -> Option<Vec<(f64, f64)>> {
    let n = points.len() as f64;
    let middle = |f: fn(&(f64, f64)) -> f64| (points.iter().map(|p| f(p).ln()).sum::<f64>() / n).exp();
    let (x, y) = (middle(|p| p.0), middle(|p| p.1));
    Some([points.first()?.0, points.last()?.0].map(|at| (at, y * (at / x).powf(slope))).to_vec())
}

pub(super) fn local_slopes(rows: &[Row]) -> Plot {
    let mut series = Vec::new();
    for (color, sampler) in SAMPLERS {
        for (of, dash) in [(Of::All, Dash::Solid), (Of::Edges, Dash::Dotted)] {
            let (points, whiskers) = over_samples(&medians(rows, sampler, of), "local_slope");
            let name = format!("{sampler}, {}", of.words());
            let stroke = Stroke::Line(dash);
            series.push(Series { whiskers, stroke, ..Series::line(name, color, points) });
        }
    }
    let samples: Vec<f64> = series.iter().flat_map(|s| &s.points).map(|p| p.0).collect();
    if let [first, .., last] = samples[..] {
        series.push(Series::dashed("−1/2: independent samples", 6, vec![(first, -0.5), (last, -0.5)]));
    }
    Plot::new(
        "Local slopes",
        Axis::new("samples per pixel, the larger of two neighbours", Scale::Log),
        Axis::new("exponent of error over samples", Scale::Linear),
        series,
    )
}

/// Seeds, pixels and samples of the figures.
fn of_what(rows: &[Row], of: Of) -> Option<String> {
    let row = of_quantity(rows, "median_error").find(|row| row.get("pixels") == of.name())?;
    Some(format!("{} pixels, {} seeds", number("pixel_count", row), number("seeds", row)))
}

pub(super) fn error_caption(of: Of, rows: &[Row]) -> String {
    let Some(what) = of_what(rows, of) else { return String::new() };
    let row = of_quantity(rows, "median_error").next();
    format!(
        "Error over samples per pixel, {}: medians over seeds with 95% intervals by order statistics ({what}). Dashed: the \
         median slope of the seeds; the slope is an exponent. The reference has {} samples, and the square of its own \
         error is subtracted; errors less than three times as large as it are not drawn.",
        of.words(),
        row.map_or_else(|| "?".into(), |row| number("reference_samples", row)),
    )
}

pub(super) fn slope_caption(rows: &[Row]) -> String {
    let Some(what) = of_what(rows, Of::All) else { return String::new() };
    format!(
        "Exponent of the error from one number of samples to twice as many, medians over seeds with 95% intervals by order \
         statistics ({what}; edges: fewer pixels). Within a seed, neighbours share samples."
    )
}
