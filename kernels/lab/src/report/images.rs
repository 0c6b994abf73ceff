//! Images of few and many samples beside a reference: what the sections on light share.
//!
//! A seed's image of few samples is the beginning of its image of many; seeds are independent. The reference is the mean of two
//! images with more samples and with seeds of their own; half the difference of the two estimates its own error, which is
//! independent of the measured one, so its square is subtracted from the square of the difference.

pub(super) mod plots;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use raystep_kernels::{Image, Options, Renderer, Samples};

use super::work::{Planned, Work};
use crate::Error;
use crate::flip::flip;
use crate::statistics::{interval, median, root_mean_square};
use crate::tidy::Row;

/// Time limit of the section where it has none of its own; what is not measured by then is omitted.
const LONGEST: Duration = Duration::from_secs(600);
/// Share of the section's time for images; the rest is for the time of a sample.
const FOR_IMAGES: f64 = 0.8;

/// This many samples of a seed.
pub(super) fn of_seed(count: u32, seed: u32) -> Samples {
    Samples { count, seed, ..Samples::default() }
}

/// Two images of `each` samples; `None` if they take too long.
pub(super) fn halves(
    work: &Work<'_>,
    each: u32,
    options: impl Fn(Samples) -> Options,
) -> Result<Option<[Image; 2]>, Error> {
    work.stage(&format!("{}: the reference", work.section));
    let mut halves = Vec::new();
    // After the seeds of the measured images.
    let first = work.seed().wrapping_add(work.seeds);
    for seed in [first, first.wrapping_add(1)] {
        let mut renderer = work.wait(work.build(&options(of_seed(each, seed))))?.renderer;
        if !run_to(work, &mut renderer, each)? {
            return Ok(None);
        }
        halves.push(work.wait(renderer.image())?);
    }
    Ok(halves.try_into().ok())
}

/// The mean of two images.
pub(super) fn mean(mut image: Image, other: &Image) -> Image {
    for (pixel, other) in image.pixels.iter_mut().zip(&other.pixels) {
        (0..4).for_each(|c| pixel[c] = 0.5 * (pixel[c] + other[c]));
    }
    image
}

/// Runs until this many samples are complete; `false` if that takes too long.
pub(super) fn run_to(work: &Work<'_>, renderer: &mut Renderer, samples: u32) -> Result<bool, Error> {
    let longest = work.time.map_or(LONGEST, |time| time.mul_f64(FOR_IMAGES));
    let watch = |progress: &raystep_kernels::Progress| {
        work.reporter.part("samples", u64::from(progress.samples), u64::from(progress.samples_wanted));
        if work.begin.elapsed() > longest { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    match crate::block_on(work.machine().gpu(), renderer.run_to_sample(samples, watch)) {
        Ok(()) => Ok(true),
        Err(raystep_kernels::RenderError::Cancelled { .. }) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// Error of linear red, green and blue, over all pixels or some.
pub(super) fn rmse(a: &Image, b: &Image, of: Option<&[bool]>) -> Option<f64> {
    let pixels = a.pixels.iter().zip(&b.pixels).enumerate();
    let wanted = pixels.filter(|(i, _)| of.is_none_or(|of| of[*i]));
    root_mean_square(wanted.flat_map(|(_, (a, b))| [0, 1, 2].map(|c| f64::from(a[c]) - f64::from(b[c]))))
}

/// What images are compared with.
pub(super) struct Reference {
    pub(super) image: Image,
    pub(super) samples: u32,
    /// Its estimated error.
    pub(super) error: Option<f64>,
}

impl Reference {
    /// The mean of two images of `each` samples, and half their difference; `None` if they take too long.
    pub(super) fn new(work: &Work<'_>, each: u32, options: impl Fn(Samples) -> Options) -> Result<Option<Self>, Error> {
        let Some([one, other]) = halves(work, each, options)? else { return Ok(None) };
        let error = rmse(&one, &other, None).map(|difference| 0.5 * difference);
        Ok(Some(Self { image: mean(one, &other), samples: 2 * each, error }))
    }

    /// Fills the columns of an image: its size, and how it differs.
    pub(super) fn compare(&self, image: &Image, row: Row) -> Row {
        let colors = |image: &Image| image.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect::<Vec<_>>();
        let size = [image.width, image.height].map(|side| side as usize);
        let seen = flip(&colors(&self.image), &colors(image), size);
        let seen = seen.map(|of| of.iter().map(|&v| f64::from(v)).sum::<f64>() / of.len() as f64);
        let apart = rmse(image, &self.image, None);
        let error = apart.zip(self.error).map(|(rmse, own)| (rmse * rmse - own * own).max(0.0).sqrt());
        let row = row.set("width_px", image.width).set("height_px", image.height);
        let row = row.set("reference_samples", self.samples).set("reference_rmse", self.error);
        row.set("rmse", apart).set("error", error).set("flip", seen)
    }
}

/// Images of one seed at 2, 4, 8… samples, with their numbers; `None` if they take too long.
pub(super) fn images(
    work: &Work<'_>,
    planned: &Planned,
    options: &Options,
) -> Result<Option<Vec<(u32, Image)>>, Error> {
    let mut data = planned.data().clone();
    data.sampling.seed = options.samples.seed;
    let device = &work.machine().device;
    let mut renderer = work.wait(Renderer::from_plan(planned.plan(), Arc::new(data), options, device))?;
    let mut images = Vec::new();
    for count in counts(options.samples.count) {
        if !run_to(work, &mut renderer, count)? {
            return Ok(None);
        }
        images.push((count, work.wait(renderer.image())?));
    }
    Ok(Some(images))
}

/// 2, 4, 8… samples. Not from 1: one of several samples is anywhere in its pixel, whereas an image with a single sample uses
/// the pixel's centre.
pub(super) fn counts(most: u32) -> impl Iterator<Item = u32> {
    (1..=most.ilog2()).map(|doublings| 1 << doublings)
}

/// Whether an error is so much larger than the reference's own that it hardly depends on the estimate of that.
pub(super) fn is_clear(row: &Row) -> bool {
    const CLEARLY: f64 = 3.0;
    let apart = row.number("rmse").zip(row.number("reference_rmse"));
    apart.is_some_and(|(rmse, own)| rmse > 0.0 && rmse > CLEARLY * own)
}

/// Fills a row with medians over the rows of seeds, with their intervals, and with what these share.
pub(super) fn medians(row: Row, seeds: &[&Row], seed: u32) -> Row {
    let row = row.set("seeds", seeds.len()).set("is_fitted", seeds.iter().all(|row| is_clear(row)));
    let shared = ["accelerator", "max_depth", "width_px", "height_px", "reference_samples", "reference_rmse"];
    let first = seeds.first();
    let row = shared.into_iter().fold(row, |row, column| row.set(column, first.map_or("", |first| first.get(column))));
    ["error", "flip"].into_iter().fold(row, |row, column| {
        let values: Vec<f64> = seeds.iter().filter_map(|row| row.number(column)).collect();
        let interval = interval::of_median(&values, u64::from(seed));
        row.median(column, median(&values).map(|median| (median, interval))).method(interval)
    })
}
