//! Several samples per pixel: how the image's error falls with their number.
//!
//! Seeds are independent sequences of samples, but a seed's image of few samples is the beginning of its image of many:
//! errors of one seed depend on each other. A slope is fitted to every seed, and only the slopes are independent
//! observations with an interval.
//!
//! An error that is less than three times as large as the reference's own depends on the estimate of that, and is not fitted.

mod plots;
mod slopes;

use std::ops::ControlFlow;

use raystep_kernels::{Image, Options, RaySource, Sampler, Samples, ScheduleKind};

use super::images::{halves, images, mean, rmse};
use super::page::{Part, number};
use super::words::{compared, with_interval};
use super::work::{Planned, Work};
use crate::Error;
use crate::tidy::{KEYS, RATIO, Row, TIMES, Table, count, joined};
use slopes::{Of, of_quantity};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![
        quantity sampler pixels seed seeds samples width_px height_px pixel_count rmse reference_samples
        reference_rmse error error_low error_high is_fitted local_slope local_slope_low local_slope_high
        slope slope_low slope_high rays ns_per_ray
    ],
    TIMES,
    RATIO,
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Samples of a timed run.
const TIMED: u32 = 16;

struct Reference {
    image: Image,
    samples: u32,
    is_edge: Vec<bool>,
    /// Estimated errors of all pixels and of edges.
    error: [Option<f64>; 2],
}

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    let most: u32 = work.either(64, 256);
    let Some(reference) = reference(work, most)? else {
        part.notes.push("stopped: too slow".into());
        return Ok(part);
    };
    let images = Images { work, most, reference };
    let mut rows = Vec::new();
    for &sampler in Sampler::ALL {
        work.stage(&format!("samples, {sampler}"));
        let planned = work.plan(&options(work, Samples { count: most, sampler, seed: work.seed(), first: 0 }))?;
        for seed in seeds(work) {
            match images.of_seed(&planned, sampler, seed)? {
                Some(of_seed) => rows.extend(of_seed),
                None => {
                    part.notes.push(format!("{sampler}, seed {seed} and later: left out, too slow"));
                    break;
                }
            }
        }
    }
    let blank = |sampler: &str, what: &str| {
        work.row(COLUMNS).set("configuration", work.configuration(&[sampler, what])).set("sampler", sampler)
    };
    slopes::fill(&mut rows);
    let found = slopes::of_seeds(&rows, |sampler, seed| blank(sampler, &format!("seed-{seed}")));
    rows.extend(found);
    let found = slopes::medians(&rows, u64::from(work.seed()), |sampler| blank(sampler, "all-seeds"));
    rows.extend(found);
    rows.extend(timed(work, &mut part)?);
    for of in Of::ALL {
        part.figure(of.name(), plots::errors(of, &rows), plots::error_caption(of, &rows));
    }
    part.figure("slopes", plots::local_slopes(&rows), plots::slope_caption(&rows));
    part.table(rows.iter().filter(|row| row.get("seed").is_empty()));
    say(work, &rows, &mut part);
    table.rows.extend(rows);
    Ok(part)
}

/// The seeds of the measured images.
pub(super) fn seeds(work: &Work<'_>) -> impl Iterator<Item = u32> {
    let first = work.seed();
    (0..work.seeds).map(move |i| first.wrapping_add(i))
}

fn options(work: &Work<'_>, samples: Samples) -> Options {
    Options { schedule: ScheduleKind::Fused, samples, keep_passes: false, ..Options::new(rays(work)) }
}

/// Small images, since many samples are needed.
pub(super) fn rays(work: &Work<'_>) -> RaySource {
    let side = work.either(32, 64);
    let mut size = work.size;
    size.height = size.height.min(side);
    size.width = size.width.min(side);
    Work { size, ..*work }.camera_rays()
}

fn reference(work: &Work<'_>, most: u32) -> Result<Option<Reference>, Error> {
    let Some([one, other]) = halves(work, 4 * most, |samples| options(work, samples))? else { return Ok(None) };
    let is_edge = edges(work)?;
    let error = [None, Some(&is_edge)].map(|of| rmse(&one, &other, of.map(Vec::as_slice)).map(|e| 0.5 * e));
    Ok(Some(Reference { image: mean(one, &other), samples: 8 * most, is_edge, error }))
}

/// Pixels where a neighbour's centre hits another triangle.
fn edges(work: &Work<'_>) -> Result<Vec<bool>, Error> {
    let options = Options { shade: false, ..Options::new(rays(work)) };
    let mut renderer = work.wait(work.build(&options))?.renderer;
    work.wait(renderer.run(|_| ControlFlow::Continue(())))?;
    let hits = work.wait(renderer.hits())?;
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

/// What the images of all seeds share.
struct Images<'a> {
    work: &'a Work<'a>,
    /// Samples of the last image.
    most: u32,
    reference: Reference,
}

impl Images<'_> {
    /// Errors of one seed's images of 2, 4, 8… samples; `None` if they take too long.
    fn of_seed(&self, planned: &Planned, sampler: Sampler, seed: u32) -> Result<Option<Vec<Row>>, Error> {
        let Self { work, most, reference } = self;
        let samples = Samples { count: *most, sampler, seed, first: 0 };
        let Some(images) = images(work, planned, &options(work, samples))? else { return Ok(None) };
        let mut rows = Vec::new();
        for (count, image) in &images {
            for (of, own) in Of::ALL.into_iter().zip(reference.error) {
                let is_edge = (of == Of::Edges).then_some(reference.is_edge.as_slice());
                let pixels = is_edge.map_or(image.pixels.len(), |is| is.iter().filter(|is| **is).count());
                let row = work
                    .row(COLUMNS)
                    .set("configuration", work.configuration(&[sampler.name(), &format!("seed-{seed}")]));
                let row = row.set("quantity", "error").set("sampler", sampler.name()).set("pixels", of.name());
                let row = row.set("seed", seed).set("samples", *count);
                let row = row.set("width_px", image.width).set("height_px", image.height).set("pixel_count", pixels);
                let row = row.set("rmse", rmse(image, &reference.image, is_edge));
                rows.push(row.set("reference_samples", reference.samples).set("reference_rmse", own));
            }
        }
        Ok(Some(rows))
    }
}

/// The time of a sample, of both samplers in turn.
fn timed(work: &Work<'_>, part: &mut Part) -> Result<Vec<Row>, Error> {
    work.stage("samples: their time");
    let mut built = Vec::new();
    for &sampler in Sampler::ALL {
        let samples = Samples { count: TIMED, sampler, seed: work.seed(), first: 0 };
        built.push(work.wait(work.build(&options(work, samples)))?.renderer);
    }
    let names: Vec<_> = Sampler::ALL.iter().map(|s| work.configuration(&[s.name(), "time"])).collect();
    let rays = built.iter().map(|renderer| renderer.plan().rays * u64::from(TIMED)).collect::<Vec<_>>();
    let mut renderers: Vec<_> = built.iter_mut().collect();
    let times = work.wait(work.time_in_turn(&names, &mut renderers, work.either(6, 20)))?;
    let (mut rows, mut first) = (Vec::new(), None);
    for (i, (sampler, times)) in Sampler::ALL.iter().zip(&times).enumerate() {
        if times.is_given_up() || times.is_missing() {
            part.notes.push(format!("{sampler}: no time, too slow"));
            continue;
        }
        let row = work.row(COLUMNS).set("configuration", &*names[i]).set("quantity", "time");
        let row =
            row.set("sampler", sampler.name()).set("samples", TIMED).set("rays", rays[i]).set("clock", work.clock());
        let per_ray = times.median().filter(|_| rays[i] > 0).map(|ns| ns / rays[i] as f64);
        let row = times.fill(row.set("ns_per_ray", per_ray), work.seed());
        rows.push(match first {
            Some(first) => times.fill_ratio(first, &names[0], row, work.seed()),
            None => row,
        });
        first = first.or(Some(times));
    }
    Ok(rows)
}

fn say(work: &Work<'_>, rows: &[Row], part: &mut Part) {
    for of in Of::ALL {
        for sampler in Sampler::ALL {
            let is_of = |row: &&Row| row.is(&[("sampler", sampler.name()), ("pixels", of.name())]);
            let of_quantity = |quantity: &'static str| of_quantity(rows, quantity).filter(is_of);
            let Some(slope) = of_quantity("median_slope").next() else { continue };
            let mut local: Vec<&Row> =
                of_quantity("median_error").filter(|r| r.number("local_slope").is_some()).collect();
            local.sort_by(|a, b| {
                a.number("local_slope").partial_cmp(&b.number("local_slope")).unwrap_or(std::cmp::Ordering::Equal)
            });
            let range = match (local.first(), local.last()) {
                (Some(steep), Some(flat)) => format!(
                    "; from one number of samples to the next between {} and {}",
                    number("local_slope", steep),
                    number("local_slope", flat)
                ),
                _ => String::new(),
            };
            let dropped = of_quantity("median_error").find(|r| r.get("is_fitted") == "false").map_or(String::new(), |row| {
                format!(
                    " From {} samples on, the reference's own error, {}, is more than a third of the error: not fitted.",
                    number("samples", row),
                    number("reference_rmse", row)
                )
            });
            part.prose.push(format!(
                "{sampler}, {}: the error is proportional to samples to the power {}, the median of {} seeds{range}.\
                 {dropped}",
                of.words(),
                with_interval("slope", slope),
                number("seeds", slope),
            ));
        }
    }
    if let Some(row) = of_quantity(rows, "time").find(|row| row.number("time_ratio").is_some()) {
        let verdict = compared("time_ratio", row).words();
        let other = of_quantity(rows, "time").find(|row| row.number("time_ratio").is_none());
        part.prose.push(format!(
            "Time: a run of {} samples with {} takes {} times as long as with {}, in {} pairs of runs: {verdict}. Times are {}.",
            number("samples", row),
            row.get("sampler"),
            with_interval("time_ratio", row),
            other.map_or("the other sampler", |row| row.get("sampler")),
            number("runs", row),
            work.clock_in_words()
        ));
    }
    if let Some(row) = rows.iter().find(|row| row.get("quantity") == "error") {
        let of_edges = rows.iter().find(|row| row.is(&[("quantity", "error"), ("pixels", "edges")]));
        part.prose.push(format!(
            "{} × {} pixels, {} of them at edges. The reference has {} samples per pixel with seeds of its own; the square \
             of its own error is subtracted. Seeds are independent sequences; a seed's image of few samples is the \
             beginning of its image of many.",
            number("width_px", row),
            number("height_px", row),
            of_edges.map_or_else(|| "?".into(), |row| number("pixel_count", row)),
            number("reference_samples", row),
        ));
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
