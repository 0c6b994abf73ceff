//! Several samples per pixel: the image's error over time.
//!
//! The reference is the mean of two images with more samples and with seeds of their own; half the difference of the
//! two estimates the reference's own error, as both are independent. An error that is less than ten times as large
//! cannot be told from the reference's, and is not plotted.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use raystep_kernels::{Image, Options, RaySource, Renderer, Sampler, Samples, ScheduleKind};

use super::page::{Part, number};
use super::work::Work;
use crate::Error;
use crate::plots::{Axis, Mark, Plot, Scale, Series, Stroke};
use crate::statistics::{power_law, root_mean_square};
use crate::tidy::{KEYS, Row, Table, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    &[
        "sampler",
        "samples",
        "width_px",
        "height_px",
        "time_ns",
        "rmse",
        "is_plotted",
        "slope",
        "edge_pixels",
        "edges_rmse",
        "edges_is_plotted",
        "edges_slope",
        "reference_samples",
        "reference_rmse",
        "edges_reference_rmse",
        "clock",
    ],
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

const SHOWN: &[&str] = &[
    "sampler",
    "samples",
    "time_ns",
    "rmse",
    "is_plotted",
    "edges_rmse",
    "edges_is_plotted",
    "reference_samples",
    "reference_rmse",
    "edges_reference_rmse",
];

/// How many times smaller the reference's own error must be.
const CLEARLY: f64 = 10.0;

/// Time limit for the section; what is not measured by then is omitted.
const LONGEST: Duration = Duration::from_secs(600);

/// Pixels in which the error is measured.
#[derive(Clone, Copy)]
enum Of {
    All,
    Edges,
}

/// Column names for errors of all pixels, or of edge pixels.
impl Of {
    fn figure(self) -> &'static str {
        match self {
            Self::All => "pixels",
            Self::Edges => "edges",
        }
    }

    fn column(self, name: &str) -> String {
        match self {
            Self::All => name.to_owned(),
            Self::Edges => format!("edges_{name}"),
        }
    }
}

struct Reference {
    image: Image,
    samples: u32,
    is_edge: Vec<bool>,
    /// Estimated errors of all pixels and of edges.
    error: [Option<f64>; 2],
}

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    let first = table.rows.len();
    let begin = Instant::now();
    let most: u32 = work.either(64, 1024);
    match reference(work, most, begin)? {
        None => part.notes.push("stopped: too slow".into()),
        Some(reference) => {
            for &sampler in Sampler::ALL {
                work.stage(&format!("samples, {sampler}"));
                let rows = one(work, sampler, most, &reference, begin, &mut part)?;
                table.rows.extend(rows);
            }
        }
    }
    let rows = &mut table.rows[first..];
    fit(rows);
    say(work, rows, &mut part);
    for of in [Of::All, Of::Edges] {
        part.figure(of.figure(), plot(of, rows).svg()?, "");
    }
    part.table(rows.iter(), SHOWN);
    Ok(part)
}

fn options(work: &Work<'_>, samples: Samples) -> Options {
    Options { schedule: ScheduleKind::Fused, samples, keep_passes: false, ..Options::new(rays(work)) }
}

/// Small images, since many samples are needed.
fn rays(work: &Work<'_>) -> RaySource {
    let side = work.either(48, 96);
    let mut size = work.size;
    size.height = size.height.min(side);
    size.width = size.width.min(side);
    Work { size, ..*work }.camera_rays()
}

/// Runs until this many samples are complete; `false` if that takes too long.
fn run_to(work: &Work<'_>, renderer: &mut Renderer, samples: u32, begin: Instant) -> Result<bool, Error> {
    let watch = |progress: &raystep_kernels::Progress| {
        work.reporter.part("samples", u64::from(progress.samples), u64::from(progress.samples_wanted));
        if begin.elapsed() > LONGEST { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    match crate::block_on(work.machine().gpu(), renderer.run_to_sample(samples, watch)) {
        Ok(()) => Ok(true),
        Err(raystep_kernels::RenderError::Cancelled { .. }) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

fn reference(work: &Work<'_>, most: u32, begin: Instant) -> Result<Option<Reference>, Error> {
    work.stage("samples: the reference");
    let each = 2 * most;
    let mut halves = Vec::new();
    for half in 0..2 {
        let samples = Samples { count: each, sampler: Sampler::Sobol, seed: work.seed() + 1 + half };
        let mut renderer = work.build(&options(work, samples))?.renderer;
        if !run_to(work, &mut renderer, each, begin)? {
            return Ok(None);
        }
        halves.push(work.machine().wait(renderer.image())?);
    }
    let (Some(mut image), Some(other)) = (halves.pop(), halves.pop()) else { return Ok(None) };
    let is_edge = edges(work)?;
    let error = [None, Some(&is_edge)].map(|of| rmse(&image, &other, of.map(Vec::as_slice)).map(|e| 0.5 * e));
    for (pixel, other) in image.pixels.iter_mut().zip(&other.pixels) {
        (0..4).for_each(|c| pixel[c] = 0.5 * (pixel[c] + other[c]));
    }
    Ok(Some(Reference { image, samples: 2 * each, is_edge, error }))
}

/// Pixels where a neighbour's centre hits another triangle.
fn edges(work: &Work<'_>) -> Result<Vec<bool>, Error> {
    let options = Options { shade: false, ..Options::new(rays(work)) };
    let mut renderer = work.build(&options)?.renderer;
    work.machine().wait(renderer.run(|_| ControlFlow::Continue(())))?;
    let hits = work.machine().wait(renderer.hits())?;
    let (width, height) = (renderer.plan().width as usize, renderer.plan().height as usize);
    let seen: Vec<Option<u32>> = hits.iter().map(|hit| hit.map(|h| h.triangle)).collect();
    Ok(edges_of(&seen, width, height))
}

fn edges_of(seen: &[Option<u32>], width: usize, height: usize) -> Vec<bool> {
    let at = |x: usize, y: usize| seen[y * width + x];
    let is_edge = |i: usize| {
        let (x, y) = (i % width, i / width);
        x > 0 && at(x - 1, y) != at(x, y)
            || y > 0 && at(x, y - 1) != at(x, y)
            || x + 1 < width && at(x + 1, y) != at(x, y)
            || y + 1 < height && at(x, y + 1) != at(x, y)
    };
    (0..width * height).map(is_edge).collect()
}

/// Error of linear red, green and blue, over all pixels or some.
fn rmse(a: &Image, b: &Image, of: Option<&[bool]>) -> Option<f64> {
    let pixels = a.pixels.iter().zip(&b.pixels).enumerate();
    let wanted = pixels.filter(|(i, _)| of.is_none_or(|of| of[*i]));
    root_mean_square(wanted.flat_map(|(_, (a, b))| [0, 1, 2].map(|c| f64::from(a[c]) - f64::from(b[c]))))
}

fn one(
    work: &Work<'_>,
    sampler: Sampler,
    most: u32,
    reference: &Reference,
    begin: Instant,
    part: &mut Part,
) -> Result<Vec<Row>, Error> {
    let samples = Samples { count: most, sampler, seed: work.seed() };
    let mut renderer = work.build(&options(work, samples))?.renderer;
    let mut rows = Vec::new();
    // Warm up once. Do not start at 1: one of several samples is anywhere in its pixel, whereas an image with a single
    // sample uses the pixel's centre.
    let mut count = 2;
    run_to(work, &mut renderer, count, begin)?;
    renderer.restart();
    let mut wall = Duration::ZERO;
    while count <= most {
        work.machine().settle();
        let started = Instant::now();
        let is_there = run_to(work, &mut renderer, count, begin)?;
        // Stopped runs count too: their samples are used below.
        wall += started.elapsed();
        if !is_there {
            part.notes.push(format!("{sampler}: stopped before {count} samples: too slow"));
            break;
        }
        let image = work.machine().wait(renderer.image())?;
        let errors = [None, Some(reference.is_edge.as_slice())].map(|of| rmse(&image, &reference.image, of));
        let plotted = |i: usize| Some(errors[i]? > 0.0 && errors[i]? > CLEARLY * reference.error[i]?);
        rows.push(
            work.row(COLUMNS)
                .set("configuration", work.configuration(&[sampler.name(), &count.to_string()]))
                .set("sampler", sampler.name())
                .set("samples", count)
                .set("width_px", image.width)
                .set("height_px", image.height)
                .set("rmse", errors[0])
                .set("is_plotted", plotted(0))
                .set("edge_pixels", reference.is_edge.iter().filter(|is| **is).count())
                .set("edges_rmse", errors[1])
                .set("edges_is_plotted", plotted(1))
                .set("reference_samples", reference.samples)
                .set("reference_rmse", reference.error[0])
                .set("edges_reference_rmse", reference.error[1])
                .set("clock", work.clock()),
        );
        count *= 2;
    }
    // Every sample traces equally many rays, and passes of several samples are submitted together, so the run's time is
    // divided equally among samples.
    let done = renderer.samples().max(1);
    let has_clock = work.machine().timer().times_passes();
    let total = if has_clock { renderer.device_ns() } else { Some(wall.as_nanos() as u64) };
    let per_sample = total.filter(|&ns| ns > 0).map(|ns| ns as f64 / f64::from(done));
    let timed = |row: Row| {
        let time = per_sample.zip(row.number("samples")).map(|(ns, samples)| ns * samples);
        row.set("time_ns", time)
    };
    Ok(rows.into_iter().map(timed).collect())
}

fn points(rows: &[Row], sampler: &str, of: Of, x: &str) -> Vec<(f64, f64)> {
    let wanted = rows.iter().filter(|r| r.is(&[("sampler", sampler), (&of.column("is_plotted"), "true")]));
    wanted.filter_map(|r| Some((r.number(x)?, r.number(&of.column("rmse"))?))).collect()
}

/// Adds the exponents of error against samples.
fn fit(rows: &mut [Row]) {
    for of in [Of::All, Of::Edges] {
        for sampler in Sampler::ALL {
            let slope = power_law(&points(rows, sampler.name(), of, "samples"));
            for row in rows.iter_mut().filter(|r| r.get("sampler") == sampler.name()) {
                *row = row.clone().set(&of.column("slope"), slope);
            }
        }
    }
}

fn say(work: &Work<'_>, rows: &[Row], part: &mut Part) {
    for (of, name) in [(Of::All, "all pixels"), (Of::Edges, "pixels at edges")] {
        for sampler in Sampler::ALL {
            let of_sampler = || rows.iter().filter(|r| r.get("sampler") == sampler.name());
            let Some(row) = of_sampler().find(|r| r.number(&of.column("slope")).is_some()) else { continue };
            let slope = number(&of.column("slope"), row);
            let dropped: Vec<&Row> = of_sampler().filter(|r| r.get(&of.column("is_plotted")) != "true").collect();
            let dropped = match dropped.first() {
                Some(first) => format!(
                    " From {} samples on, the reference's own error, {}, is more than a tenth of the error, so these \
                     are not plotted.",
                    number("samples", first),
                    number(&of.column("reference_rmse"), row)
                ),
                None => String::new(),
            };
            part.prose.push(format!(
                "{sampler}, {name}: the error is proportional to samples to the power \
                                     {slope}.{dropped}"
            ));
        }
    }
    if let Some(row) = rows.first() {
        part.prose.push(format!(
            "{} × {} pixels, {} of them at edges. The reference has {} samples per pixel with other seeds. Times are \
             {}, divided equally among a run's samples.",
            number("width_px", row),
            number("height_px", row),
            number("edge_pixels", row),
            number("reference_samples", row),
            work.clock_in_words()
        ));
    }
}

fn plot(of: Of, rows: &[Row]) -> Plot {
    let mut series = Vec::new();
    for (color, sampler, mark) in [(0, Sampler::Sobol, Mark::Dot), (1, Sampler::Random, Mark::Triangle)] {
        let over_time: Vec<_> =
            points(rows, sampler.name(), of, "time_ns").into_iter().map(|(ns, rmse)| (ns / 1e6, rmse)).collect();
        // The fitted slope, through the middle point.
        let row = rows.iter().find(|r| r.get("sampler") == sampler.name());
        let slope = row.and_then(|r| r.number(&of.column("slope")));
        let ends = over_time.first().zip(over_time.last()).zip(slope).map(|((first, last), slope)| {
            let n = over_time.len() as f64;
            let middle = |f: fn(&(f64, f64)) -> f64| (over_time.iter().map(|p| f(p).ln()).sum::<f64>() / n).exp();
            let (x, y) = (middle(|p| p.0), middle(|p| p.1));
            [first.0, last.0].map(|at| (at, y * (at / x).powf(slope))).to_vec()
        });
        series.push(Series { mark, ..Series::line(sampler.name(), color, over_time) });
        if let (Some(ends), Some(row)) = (ends, row) {
            // Formatted as in the CSV.
            let slope = row.get(&of.column("slope"));
            series.push(Series::dashed(format!("{sampler}: slope {slope}"), color, ends));
        }
    }
    let own = rows.iter().find_map(|r| r.number(&of.column("reference_rmse")));
    let times: Vec<f64> = rows.iter().filter_map(|r| Some(r.number("time_ns")? / 1e6)).collect();
    let (low, high) = times.iter().fold((f64::INFINITY, 0.0), |(l, h), &t| (f64::min(l, t), f64::max(h, t)));
    if let Some(own) = own.filter(|_| low <= high) {
        let points = vec![(low, own), (high, own)];
        series.push(Series { stroke: Stroke::Dashed, ..Series::dashed("error of the reference", 6, points) });
    }
    let title = match of {
        Of::All => "Error of the image over time, all pixels",
        Of::Edges => "Error of the image over time, pixels at edges",
    };
    Plot {
        title: title.into(),
        x: Axis::new("time, ms", Scale::Log),
        y: Axis::new("root mean square error, linear light", Scale::Log),
        series,
        places: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_is_where_a_neighbour_sees_another_triangle() {
        let seen = [Some(1), Some(1), Some(2), Some(1), Some(1), Some(1), None, Some(1), Some(1)];
        assert_eq!(edges_of(&seen, 3, 3), [false, true, true, true, false, true, true, true, false]);
    }

    #[test]
    fn errors_are_of_three_channels_and_of_the_pixels_that_count() {
        let image = |v: f32| Image { width: 2, height: 1, pixels: vec![[v, v, v, 1.0], [0.0; 4]] };
        let error = |of: Option<&[bool]>| rmse(&image(0.5), &image(0.0), of).expect("pixels");
        assert!((error(None) - 0.5 / 2f64.sqrt()).abs() < 1e-12);
        assert!((error(Some(&[true, false])) - 0.5).abs() < 1e-12);
        assert_eq!(rmse(&image(1.0), &image(0.0), Some(&[false, false])), None);
    }
}
