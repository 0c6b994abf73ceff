//! Slopes of errors over samples, from the rows of the measured errors alone.

use raystep_kernels::{Sampler, named};

use super::super::images::is_clear;
use crate::statistics::interval;
use crate::statistics::{median, power_law};
use crate::tidy::Row;

/// Pixels in which the error is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Of {
    /// All of them.
    All,
    /// Those at edges.
    Edges,
}

named!(Of, All "all", Edges "edges");

impl Of {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::All => "all pixels",
            Self::Edges => "pixels at edges",
        }
    }
}

/// The rows of one quantity.
pub(super) fn of_quantity<'a>(rows: &'a [Row], quantity: &str) -> impl Iterator<Item = &'a Row> {
    rows.iter().filter(move |row| row.get("quantity") == quantity)
}

/// Every sampler with every kind of pixels.
fn groups() -> impl Iterator<Item = (&'static str, Of)> {
    Sampler::ALL.iter().flat_map(|sampler| Of::ALL.map(|of| (sampler.name(), of)))
}

/// The errors of a sampler.
fn errors<'a>(rows: &'a [Row], (sampler, of): (&'a str, Of)) -> Vec<&'a Row> {
    rows.iter().filter(|row| row.is(&[("quantity", "error"), ("sampler", sampler), ("pixels", of.name())])).collect()
}

/// The different fields of a column, in their order.
fn different<'a>(rows: &[&'a Row], column: &str) -> Vec<&'a str> {
    let mut fields = Vec::new();
    for row in rows {
        let field = row.get(column);
        if !fields.contains(&field) {
            fields.push(field);
        }
    }
    fields
}

/// Subtracts the reference's own error, and tells which errors are fitted: those of a number of samples for which every
/// seed's error is clearly above the reference's.
pub(super) fn fill(rows: &mut [Row]) {
    for row in rows.iter_mut() {
        let error = row.number("rmse").zip(row.number("reference_rmse"));
        let error = error.map(|(rmse, own)| (rmse * rmse - own * own).max(0.0).sqrt());
        *row = row.clone().set("error", error);
    }
    let key = |row: &Row| ["sampler", "pixels", "samples"].map(|column| row.get(column).to_owned());
    let unclear: Vec<_> = rows.iter().filter(|row| !is_clear(row)).map(key).collect();
    for row in rows.iter_mut() {
        let is_fitted = !unclear.contains(&key(row));
        *row = row.clone().set("is_fitted", is_fitted);
    }
    // Slopes from the previous number of samples, of the same seed.
    let points: Vec<_> = rows.iter().map(|row| (key(row), row.get("seed").to_owned(), fitted(row))).collect();
    for (row, (key, seed, point)) in rows.iter_mut().zip(&points) {
        let before = point.and_then(|(samples, _)| {
            let is_before = |(other, of, point): &&(_, String, Option<(f64, f64)>)| {
                let [sampler, pixels, _]: &[String; 3] = other;
                [sampler, pixels] == [&key[0], &key[1]] && of == seed && point.is_some_and(|p| p.0 < samples)
            };
            let before = points.iter().filter(is_before).filter_map(|(_, _, point)| *point);
            before.max_by(|a, b| a.0.total_cmp(&b.0))
        });
        let slope = point.zip(before).and_then(|(now, before)| power_law(&[before, now]));
        *row = row.clone().set("local_slope", slope);
    }
}

/// Samples and error of a row that is fitted.
fn fitted(row: &Row) -> Option<(f64, f64)> {
    let is_fitted = row.get("is_fitted") == "true";
    row.number("samples").zip(row.number("error")).filter(|point| is_fitted && point.1 > 0.0)
}

/// The slope of each seed: the exponent of error over samples.
pub(super) fn of_seeds(rows: &[Row], blank: impl Fn(&str, &str) -> Row) -> Vec<Row> {
    let mut slopes = Vec::new();
    for group in groups() {
        let errors = errors(rows, group);
        for seed in different(&errors, "seed") {
            let points: Vec<_> = errors.iter().filter(|r| r.get("seed") == seed).filter_map(|r| fitted(r)).collect();
            if let Some(slope) = power_law(&points) {
                let row = blank(group.0, seed).set("quantity", "slope").set("pixels", group.1.name());
                slopes.push(row.set("seed", seed).set("slope", slope));
            }
        }
    }
    slopes
}

/// Medians over seeds with their intervals: of the error and the local slope at each number of samples, and of the slope.
pub(super) fn medians(rows: &[Row], seed: u64, blank: impl Fn(&str) -> Row) -> Vec<Row> {
    let mut medians = Vec::new();
    for group in groups() {
        let errors = errors(rows, group);
        for samples in different(&errors, "samples") {
            let of: Vec<&Row> = errors.iter().copied().filter(|row| row.get("samples") == samples).collect();
            let row =
                blank(group.0).set("quantity", "median_error").set("pixels", group.1.name()).set("samples", samples);
            let shared = ["width_px", "height_px", "pixel_count", "reference_samples", "reference_rmse", "is_fitted"];
            let row = shared.into_iter().fold(row, |row, column| row.set(column, of[0].get(column)));
            medians.push(with_median(with_median(row, "local_slope", &of, seed), "error", &of, seed));
        }
        let is_slope = |row: &&Row| row.is(&[("quantity", "slope"), ("sampler", group.0), ("pixels", group.1.name())]);
        let slopes: Vec<&Row> = rows.iter().filter(is_slope).collect();
        if !slopes.is_empty() {
            let row = blank(group.0).set("quantity", "median_slope").set("pixels", group.1.name());
            medians.push(with_median(row, "slope", &slopes, seed));
        }
    }
    medians
}

/// Fills a column with the median of other rows', and its interval.
fn with_median(row: Row, column: &str, of: &[&Row], seed: u64) -> Row {
    let values: Vec<f64> = of.iter().filter_map(|row| row.number(column)).collect();
    let interval = interval::of_median(&values, seed);
    row.median(column, median(&values).map(|median| (median, interval))).set("seeds", values.len()).method(interval)
}

#[cfg(test)]
mod tests {
    use super::super::COLUMNS;
    use super::*;
    use crate::rays::Random;

    /// Errors of ten seeds with a known slope, and a reference with an error of its own.
    fn measured(slope: f64, own: f64) -> Vec<Row> {
        let mut random = Random::new(3);
        let mut rows = Vec::new();
        for seed in 0..10u32 {
            for k in 1..=7 {
                let samples = 2f64.powi(k);
                let error = samples.powf(slope) * (0.97 + 0.06 * random.unit());
                let row = Row::new(COLUMNS).set("quantity", "error").set("sampler", "random").set("pixels", "all");
                let row = row.set("seed", seed).set("samples", samples as u32).set("reference_rmse", own);
                rows.push(row.set("rmse", error.hypot(own)));
            }
        }
        rows
    }

    fn found(mut rows: Vec<Row>) -> Vec<Row> {
        fill(&mut rows);
        rows.extend(of_seeds(&rows, |sampler, _| Row::new(COLUMNS).set("sampler", sampler)));
        rows.extend(medians(&rows, 1, |sampler| Row::new(COLUMNS).set("sampler", sampler)));
        rows
    }

    #[test]
    fn the_slope_is_found_over_seeds_with_the_references_own_error_subtracted() {
        // A third of the last error but one: without the subtraction, the slope would be -0.58.
        let rows = found(measured(-0.6, 0.02));
        let slopes: Vec<&Row> = of_quantity(&rows, "median_slope").collect();
        assert_eq!((slopes.len(), slopes[0].get("seeds"), of_quantity(&rows, "slope").count()), (1, "10", 10));
        let [low, slope, high] = ["slope_low", "slope", "slope_high"].map(|c| slopes[0].number(c).expect("a number"));
        assert!(low < slope && slope < high && high - low < 0.03 && low < -0.6 && -0.6 < high, "{low} {slope} {high}");
        assert_eq!(slopes[0].get("interval_method"), "order_statistics");
    }

    #[test]
    fn errors_near_the_references_own_are_not_fitted_and_slopes_are_also_local() {
        let rows = found(measured(-0.6, 0.04));
        let errors: Vec<&Row> = of_quantity(&rows, "median_error").collect();
        let is_fitted: Vec<&str> = errors.iter().map(|row| row.get("is_fitted")).collect();
        // 32^-0.6 is 0.125, and 64^-0.6 is 0.082.
        assert_eq!(is_fitted, ["true", "true", "true", "true", "true", "false", "false"]);
        let local: Vec<Option<f64>> = errors.iter().map(|row| row.number("local_slope")).collect();
        assert_eq!(
            local.iter().map(Option::is_some).collect::<Vec<_>>(),
            [false, true, true, true, true, false, false]
        );
        assert!(local.iter().flatten().all(|slope| (slope + 0.6).abs() < 0.1), "{local:?}");
        assert!(errors[1].number("error_low") < errors[1].number("error_high"));
    }

    #[test]
    fn few_seeds_have_a_slope_without_an_interval() {
        let rows: Vec<Row> = measured(-0.5, 0.001).into_iter().take(3 * 7).collect();
        let rows = found(rows);
        let slope = of_quantity(&rows, "median_slope").next().expect("a slope");
        assert!(slope.number("slope").is_some() && slope.number("slope_low").is_none());
    }
}
