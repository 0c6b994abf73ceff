//! Light by photon maps beside light along paths: how errors fall with time, and what of them is bias.
//!
//! The reference is along paths, which find lamps with an area by chance, through mirrors and glass too. Lights without an
//! area they never find there, so caustics of those are missing in the reference.

mod plots;

use raystep_kernels::options::{Gather, Integrator, MOST_DEPTH, Photons};
use raystep_kernels::{Accelerator, Image, Options, ScheduleKind};

use super::images::{self, Reference, counts, images, of_seed};
use super::page::{Part, number};
use super::samples::{rays, seeds};
use super::strategies::STRUCTURES;
use super::words::with_interval;
use super::work::Work;
use crate::Error;
use crate::statistics::bias::Apart;
use crate::tidy::{KEYS, Row, TIMES, Table, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![
        quantity estimator photons_emitted accelerator seed seeds samples max_depth width_px height_px reference_samples
        reference_rmse rmse error error_low error_high is_fitted flip flip_low flip_high bias_squared bias_squared_low
        bias_squared_high variance ns_per_sample image_ns
    ],
    TIMES,
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Samples of a timed run.
const TIMED: u32 = 8;

/// A way to estimate light.
struct Way {
    name: String,
    options: Options,
    /// Samples of its last image.
    most: u32,
}

/// A seed, and its images by their numbers of samples.
type OfSeed = (u32, Vec<(u32, Image)>);

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    let scene = &work.subject.scene;
    if !scene.materials.iter().any(|material| material.emissive != [0.0; 3]) {
        part.prose
            .push("No surface of the scene emits light, so paths find no caustic to compare photons with.".into());
        return Ok(part);
    }
    let Some(accelerator) = STRUCTURES.into_iter().find(|&structure| work.only.has(structure)) else {
        part.notes.push("nothing to compare: light is traced with a grid, an irregular grid or a BVH".into());
        return Ok(part);
    };
    if !scene.lights.is_empty() && scene.materials.iter().any(|material| material.optics.is_specular()) {
        let why = "paths cannot find them there, photons can: their caustics count as errors of photons";
        part.notes.push(format!("the scene has mirrors or glass, and lights without an area: {why}"));
    }
    let ways = ways(work, accelerator);
    // First: errors take what is left of the section's time.
    let times = timed(work, &ways, &mut part)?;
    let Some(reference) =
        Reference::new(work, 8 * ways[0].most, |samples| Options { samples, ..ways[0].options.clone() })?
    else {
        part.notes.push("errors: left out, too slow".into());
        part.table(&times);
        table.rows.extend(times);
        return Ok(part);
    };
    let mut rows = measured(work, &ways, &reference, &times, &mut part)?;
    rows.extend(times);
    for column in ["error", "flip"] {
        part.figure(column, plots::over_time(&ways, &rows, column), plots::caption(work, &rows, column));
    }
    part.figure("bias", plots::apart(&ways, &rows), plots::caption(work, &rows, "bias_squared"));
    part.table(rows.iter().filter(|row| row.get("seed").is_empty()));
    say(work, &ways, &rows, &mut part);
    table.rows.extend(rows);
    Ok(part)
}

/// Paths, and photons by each way to gather them. A sample of a path takes far less time than one of a map.
fn ways(work: &Work<'_>, accelerator: Accelerator) -> Vec<Way> {
    let options = |integrator, gather| Options {
        integrator,
        accelerator,
        grid: work.grid_of(accelerator),
        schedule: ScheduleKind::Fused,
        // The most that photons have.
        max_depth: MOST_DEPTH,
        photons: Photons { count: work.either(2_000, 5_000), gather, ..Photons::default() },
        keep_passes: false,
        ..Options::new(rays(work))
    };
    let (path, photons) = (Integrator::Path, Integrator::Photons);
    let of_path = Way { name: path.to_string(), options: options(path, Gather::default()), most: work.either(32, 64) };
    let of_photons = Gather::ALL.iter().map(|&gather| Way {
        name: format!("{photons} {gather}"),
        options: options(photons, gather),
        most: work.either(16, 32),
    });
    std::iter::once(of_path).chain(of_photons).collect()
}

/// A row of a way.
fn row_of(work: &Work<'_>, way: &Way, quantity: &str, what: &str) -> Row {
    let photons = (way.options.integrator == Integrator::Photons).then_some(way.options.photons.count);
    let row = work.row(COLUMNS).set("configuration", work.configuration(&[&way.name, what])).set("quantity", quantity);
    let row = row.set("estimator", way.name.as_str()).set("photons_emitted", photons);
    row.set("accelerator", way.options.accelerator.name()).set("max_depth", way.options.max_depth)
}

/// Errors of every seed and way, at 2, 4, 8… samples, and over all seeds their medians, bias and variance. A seed that takes
/// too long is left out of all ways.
fn measured(
    work: &Work<'_>,
    ways: &[Way],
    reference: &Reference,
    times: &[Row],
    part: &mut Part,
) -> Result<Vec<Row>, Error> {
    let mut planned = Vec::new();
    for way in ways {
        planned.push(work.plan(&Options { samples: of_seed(way.most, work.seed()), ..way.options.clone() })?);
    }
    // Of each way, the images of each seed.
    let mut all: Vec<Vec<OfSeed>> = ways.iter().map(|_| Vec::new()).collect();
    'seeds: for seed in seeds(work) {
        work.stage(&format!("{}: seed {seed}", work.section));
        let mut of_all = Vec::new();
        for (way, planned) in ways.iter().zip(&planned) {
            let options = Options { samples: of_seed(way.most, seed), ..way.options.clone() };
            let Some(images) = images(work, planned, &options)? else {
                part.notes.push(format!("seed {seed} and later: left out, too slow"));
                break 'seeds;
            };
            of_all.push((seed, images));
        }
        all.iter_mut().zip(of_all).for_each(|(of_way, images)| of_way.push(images));
    }
    let truth = channels(&reference.image);
    let mut rows = Vec::new();
    for (way, of_seeds) in ways.iter().zip(&all) {
        let time = times.iter().find(|time| time.get("estimator") == way.name);
        for (place, samples) in counts(way.most).enumerate().filter(|_| !of_seeds.is_empty()) {
            let of_seed = |(seed, images): &OfSeed| {
                let row = row_of(work, way, "error", &format!("seed-{seed}"));
                reference.compare(&images[place].1, row.set("seed", *seed).set("samples", samples))
            };
            let errors: Vec<Row> = of_seeds.iter().map(of_seed).collect();
            let row = row_of(work, way, "convergence", "all-seeds").set("samples", samples);
            let row = images::medians(row, &errors.iter().collect::<Vec<_>>(), work.seed());
            let estimates: Vec<_> = of_seeds.iter().map(|(_, images)| channels(&images[place].1)).collect();
            let apart = reference.error.and_then(|own| Apart::of(&estimates, &truth, own));
            let row = row.set("bias_squared", apart.map(|apart| apart.bias_squared));
            let row = row.ends("bias_squared", apart.and_then(|apart| apart.interval));
            let image_ns = time.and_then(|time| time.number("ns_per_sample")).map(|ns| ns * f64::from(samples));
            rows.push(row.set("variance", apart.map(|apart| apart.variance)).set("image_ns", image_ns));
            rows.extend(errors);
        }
    }
    Ok(rows)
}

/// Red, green and blue of all pixels.
fn channels(image: &Image) -> Vec<f64> {
    image.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b].map(f64::from)).collect()
}

/// The time of a sample, of every way, in turn.
fn timed(work: &Work<'_>, ways: &[Way], part: &mut Part) -> Result<Vec<Row>, Error> {
    work.stage(&format!("{}: their time", work.section));
    let (mut built, mut names) = (Vec::new(), Vec::new());
    for way in ways {
        let options = Options { samples: of_seed(TIMED, work.seed()), ..way.options.clone() };
        built.push(work.wait(work.build(&options))?.renderer);
        names.push(work.configuration(&[&way.name, "time"]));
    }
    let mut renderers: Vec<_> = built.iter_mut().collect();
    let times = work.wait(work.time_in_turn(&names, &mut renderers, work.either(6, 12)))?;
    let mut rows = Vec::new();
    for (way, time) in ways.iter().zip(&times) {
        if time.is_given_up() || time.is_missing() {
            part.notes.push(format!("{}: no time, too slow", way.name));
            continue;
        }
        let per_sample = time.median().map(|ns| ns / f64::from(TIMED));
        let row = row_of(work, way, "time", "time").set("samples", TIMED).set("clock", work.clock());
        rows.push(time.fill(row.set("ns_per_sample", per_sample), work.seed()));
    }
    Ok(rows)
}

/// The rows over all seeds of a way.
fn of<'a>(rows: &'a [Row], way: &'a Way) -> impl Iterator<Item = &'a Row> {
    rows.iter().filter(move |row| row.is(&[("quantity", "convergence"), ("estimator", way.name.as_str())]))
}

fn say(work: &Work<'_>, ways: &[Way], rows: &[Row], part: &mut Part) {
    for way in ways {
        let Some(row) = of(rows, way).last() else { continue };
        part.prose.push(format!(
            "{}: {} samples in {}, error {}, FLIP {}; of the mean square error, {} is variance and {} squared bias.",
            way.name,
            number("samples", row),
            number("image_ns", row),
            with_interval("error", row),
            with_interval("flip", row),
            number("variance", row),
            with_interval("bias_squared", row),
        ));
    }
    let of_photons = rows.iter().find(|row| !row.get("photons_emitted").is_empty());
    if let Some(row) = of_photons.filter(|row| row.get("quantity") != "time") {
        part.prose.push(format!(
            "{} × {} pixels; {} photons for each sample, up to {} bounces: light of more is missing in all images. The \
             reference has {} samples per pixel along paths, with seeds of its own; its own error is {}, whose square is \
             subtracted. Squared bias is the mean product of what two different seeds are off by: it may be below 0 by chance \
             where there is none. Its interval is by the jackknife, the others by order statistics. The time of an image is \
             that of a run of {TIMED} samples, by their number; {}.",
            number("width_px", row),
            number("height_px", row),
            number("photons_emitted", row),
            number("max_depth", row),
            number("reference_samples", row),
            number("reference_rmse", row),
            work.clock_in_words(),
        ));
    }
}
