//! Light along paths: how the image's error falls with time, by strategy and by structure.
//!
//! The structures find the same hits, so the image depends on the strategy alone: errors are measured with one structure, times
//! with all. The reference is found by the strategy that weights both others.

mod plots;

use raystep_kernels::options::{Integrator, Strategy};
use raystep_kernels::{Accelerator, Image, Options, Samples, ScheduleKind};

use super::images::{self, Reference, counts, images, of_seed};
use super::page::{Part, number};
use super::samples::{rays, seeds};
use super::words::with_interval;
use super::work::{Planned, Work};
use crate::Error;
use crate::statistics::interval;
use crate::tidy::{KEYS, RATIO, Row, TIMES, Table, count, joined};

const GROUPS: &[&[&str]] = &[
    KEYS,
    columns![
        quantity path_strategy accelerator seed seeds samples max_depth width_px height_px reference_samples reference_rmse
        rmse error error_low error_high is_fitted flip flip_low flip_high ns_per_sample image_ns same_error_time_ratio
        same_error_time_ratio_low same_error_time_ratio_high
    ],
    TIMES,
    RATIO,
];

pub(super) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// Samples of a timed run.
const TIMED: u32 = 8;

/// What paths are traced with, the fastest first.
pub(super) const STRUCTURES: [Accelerator; 3] = [Accelerator::Bvh, Accelerator::Grid, Accelerator::Irregular];

pub(super) fn run(work: &Work<'_>, table: &mut Table) -> Result<Part, Error> {
    let mut part = Part::default();
    if !work.subject.scene.materials.iter().any(|material| material.emissive != [0.0; 3]) {
        part.prose.push("No surface of the scene emits light, so all strategies find light in the same way.".into());
        return Ok(part);
    }
    let structures: Vec<Accelerator> = STRUCTURES.into_iter().filter(|&structure| work.only.has(structure)).collect();
    let Some(&first) = structures.first() else {
        part.notes.push("nothing to compare: paths are traced with a grid, an irregular grid or a BVH".into());
        return Ok(part);
    };
    // First: errors take what is left of the section's time.
    let times = timed(work, &structures, &mut part)?;
    let most = work.either(32, 64);
    let by_both = |samples| options(work, Strategy::Mis, first, samples);
    let Some(reference) = Reference::new(work, 8 * most, by_both)? else {
        part.notes.push("errors: left out, too slow".into());
        part.table(&times);
        table.rows.extend(times);
        return Ok(part);
    };
    let mut rows = errors(work, first, most, &reference, &mut part)?;
    rows.extend(medians(work, &rows, most));
    rows.extend(convergence(&rows, &times, work.seed(), |parts| work.configuration(parts)));
    rows.extend(times);
    for (column, name) in [("error", "error"), ("flip", "flip")] {
        part.figure(name, plots::over_time(&rows, first, column), plots::caption(work, &rows, column));
    }
    part.table(rows.iter().filter(|row| row.get("seed").is_empty()));
    say(work, &rows, first, &mut part);
    table.rows.extend(rows);
    Ok(part)
}

fn options(work: &Work<'_>, strategy: Strategy, accelerator: Accelerator, samples: Samples) -> Options {
    Options {
        integrator: Integrator::Path,
        strategy,
        accelerator,
        grid: work.grid_of(accelerator),
        schedule: ScheduleKind::Fused,
        samples,
        keep_passes: false,
        ..Options::new(rays(work))
    }
}

/// Errors of every seed and strategy, at 2, 4, 8… samples. A seed that takes too long is left out of all strategies.
fn errors(
    work: &Work<'_>,
    accelerator: Accelerator,
    most: u32,
    reference: &Reference,
    part: &mut Part,
) -> Result<Vec<Row>, Error> {
    let mut planned = Vec::new();
    for &strategy in Strategy::ALL {
        planned.push((strategy, work.plan(&options(work, strategy, accelerator, of_seed(most, work.seed())))?));
    }
    let mut rows = Vec::new();
    for seed in seeds(work) {
        work.stage(&format!("strategies: seed {seed}"));
        let mut of_all = Vec::new();
        for (strategy, planned) in &planned {
            let samples = of_seed(most, seed);
            match errors_of(work, planned, &options(work, *strategy, accelerator, samples), reference)? {
                Some(of_one) => of_all.extend(of_one),
                None => {
                    part.notes.push(format!("seed {seed} and later: left out, too slow"));
                    return Ok(rows);
                }
            }
        }
        rows.extend(of_all);
    }
    Ok(rows)
}

/// Errors of one seed's images of a strategy; `None` if they take too long.
fn errors_of(
    work: &Work<'_>,
    planned: &Planned,
    options: &Options,
    reference: &Reference,
) -> Result<Option<Vec<Row>>, Error> {
    let Some(images) = images(work, planned, options)? else { return Ok(None) };
    let (strategy, seed) = (options.strategy.name(), options.samples.seed);
    let row = |(count, image): &(u32, Image)| {
        let row = work.row(COLUMNS).set("configuration", work.configuration(&[strategy, &format!("seed-{seed}")]));
        let row = row.set("quantity", "error").set("path_strategy", strategy).set("seed", seed).set("samples", *count);
        let row = row.set("accelerator", options.accelerator.name()).set("max_depth", options.max_depth);
        reference.compare(image, row)
    };
    Ok(Some(images.iter().map(row).collect()))
}

/// The rows of a quantity and a strategy.
fn of<'a>(rows: &'a [Row], quantity: &'a str, strategy: Strategy) -> impl Iterator<Item = &'a Row> {
    rows.iter().filter(move |row| row.is(&[("quantity", quantity), ("path_strategy", strategy.name())]))
}

/// Medians over seeds, with their intervals.
fn medians(work: &Work<'_>, rows: &[Row], most: u32) -> Vec<Row> {
    let mut medians = Vec::new();
    for (&strategy, samples) in
        Strategy::ALL.iter().flat_map(|strategy| counts(most).map(move |count| (strategy, count)))
    {
        let samples = samples.to_string();
        let seeds: Vec<&Row> = of(rows, "error", strategy).filter(|row| row.get("samples") == samples).collect();
        if seeds.is_empty() {
            continue;
        }
        let row = work.row(COLUMNS).set("configuration", work.configuration(&[strategy.name(), "all-seeds"]));
        let row = row.set("quantity", "median_error").set("path_strategy", strategy.name()).set("samples", &*samples);
        medians.push(images::medians(row, &seeds, work.seed()));
    }
    medians
}

/// The time of a sample, of every strategy with every structure, in turn.
fn timed(work: &Work<'_>, structures: &[Accelerator], part: &mut Part) -> Result<Vec<Row>, Error> {
    work.stage("strategies: their time");
    let ways: Vec<(Strategy, Accelerator)> =
        structures.iter().flat_map(|&structure| Strategy::ALL.iter().map(move |&s| (s, structure))).collect();
    let (mut built, mut names) = (Vec::new(), Vec::new());
    for &(strategy, structure) in &ways {
        built.push(work.wait(work.build(&options(work, strategy, structure, of_seed(TIMED, work.seed()))))?.renderer);
        names.push(work.configuration(&[strategy.name(), structure.name(), "time"]));
    }
    let mut renderers: Vec<_> = built.iter_mut().collect();
    let times = work.wait(work.time_in_turn(&names, &mut renderers, work.either(6, 12)))?;
    let mut rows = Vec::new();
    for (i, ((strategy, structure), time)) in ways.iter().zip(&times).enumerate() {
        if time.is_given_up() || time.is_missing() {
            part.notes.push(format!("{strategy}, {structure}: no time, too slow"));
            continue;
        }
        let row = work.row(COLUMNS).set("configuration", &*names[i]).set("quantity", "time").set("samples", TIMED);
        let row =
            row.set("path_strategy", strategy.name()).set("accelerator", structure.name()).set("clock", work.clock());
        let per_sample = time.median().map(|ns| ns / f64::from(TIMED));
        let row = time.fill(row.set("ns_per_sample", per_sample), work.seed());
        // To mis, with the same structure.
        let mis = i - i % Strategy::ALL.len();
        rows.push(if i == mis { row } else { time.fill_ratio(&times[mis], &names[mis], row, work.seed()) });
    }
    Ok(rows)
}

/// Error and time together: every median error with the time of its samples, of every structure.
fn convergence(rows: &[Row], times: &[Row], seed: u32, name: impl Fn(&[&str]) -> String) -> Vec<Row> {
    let mut together = Vec::new();
    for time in times {
        let wanted = [("quantity", "median_error"), ("path_strategy", time.get("path_strategy"))];
        for row in rows.iter().filter(|row| row.is(&wanted)) {
            let parts = [time.get("path_strategy"), time.get("accelerator"), "all-seeds"];
            let image_ns = time.number("ns_per_sample").zip(row.number("samples")).map(|(ns, samples)| ns * samples);
            let ratio = same_error(rows, row, time, seed);
            let row = row.clone().set("configuration", name(&parts)).set("quantity", "convergence");
            let row = row.set("accelerator", time.get("accelerator")).set("image_ns", image_ns);
            let [low, median, high] = [0, 1, 2].map(|end| ratio.map(|ratio| ratio[end]));
            let row = row.set("same_error_time_ratio", median).set("same_error_time_ratio_low", low);
            together.push(row.set("same_error_time_ratio_high", high));
        }
    }
    together
}

/// The time that a strategy needs for the error of mis, to that of mis, with its ends: the square of the ratio of errors of the
/// same seed, as the square of an error falls with time as one by it, times the ratio of times in the same round.
fn same_error(rows: &[Row], row: &Row, time: &Row, seed: u32) -> Option<[f64; 3]> {
    let is_fitted = |row: &Row| row.get("is_fitted") == "true";
    if !is_fitted(row) || !is_fitted(of_mis(rows, row, &["quantity", "samples"])?) {
        return None;
    }
    let key = [("quantity", "error"), ("path_strategy", row.get("path_strategy")), ("samples", row.get("samples"))];
    let pair =
        |row: &Row| row.number("error").zip(of_mis(rows, row, &["quantity", "samples", "seed"])?.number("error"));
    let pairs: Vec<(f64, f64)> = rows.iter().filter(|row| row.is(&key)).filter_map(pair).collect();
    let errors = interval::of_ratio(&pairs, u64::from(seed))?;
    let times = ["time_ratio_low", "time_ratio", "time_ratio_high"].map(|end| time.number(end));
    let [low, median, high] = times;
    Some([errors.low.powi(2) * low?, errors.median.powi(2) * median?, errors.high.powi(2) * high?])
}

/// The row of mis that is the same in these columns.
fn of_mis<'a>(rows: &'a [Row], row: &Row, columns: &[&'static str]) -> Option<&'a Row> {
    let same = columns.iter().map(|column| (*column, row.get(column)));
    let same: Vec<_> = same.chain([("path_strategy", Strategy::Mis.name())]).collect();
    rows.iter().find(|row| row.is(&same))
}

fn say(work: &Work<'_>, rows: &[Row], accelerator: Accelerator, part: &mut Part) {
    let told = |strategy: Strategy| {
        let with_first = of(rows, "convergence", strategy).filter(|row| row.get("accelerator") == accelerator.name());
        with_first.filter(|row| row.get("is_fitted") == "true").last()
    };
    for &strategy in Strategy::ALL {
        let Some(row) = told(strategy) else { continue };
        let ratio = match row.number("same_error_time_ratio") {
            Some(_) => {
                let ratio = with_interval("same_error_time_ratio", row);
                format!("; for the error of mis it needs {ratio} times the time")
            }
            None => String::new(),
        };
        part.prose.push(format!(
            "{strategy}: {} samples in {} with {accelerator}, error {}, FLIP {}{ratio}.",
            number("samples", row),
            number("image_ns", row),
            with_interval("error", row),
            with_interval("flip", row),
        ));
    }
    if let Some(row) = rows.iter().find(|row| row.get("quantity") == "median_error") {
        part.prose.push(format!(
            "{} × {} pixels, up to {} bounces. The reference has {} samples per pixel by mis, with seeds of its own; its own \
             error is {}, whose square is subtracted. Images do not depend on the structure. The time of an image is that of a run \
             of {TIMED} samples, by their number; {}. For another error, a strategy's time is taken to grow with one by the \
             square of the error.",
            number("width_px", row),
            number("height_px", row),
            number("max_depth", row),
            number("reference_samples", row),
            number("reference_rmse", row),
            work.clock_in_words(),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(quantity: &str, strategy: &str) -> Row {
        Row::new(COLUMNS).set("quantity", quantity).set("path_strategy", strategy)
    }

    /// Twice the error at twice the time of a sample takes eight times the time for the same error.
    #[test]
    fn times_for_the_same_error_are_by_its_square() {
        let errors = |strategy: &str, error: f64, is_fitted: bool| {
            let of = |quantity| row(quantity, strategy).set("samples", 4u32).set("error", error);
            let seeds = (1..=6u32).map(|seed| of("error").set("seed", seed));
            seeds.chain([of("median_error").set("is_fitted", is_fitted)]).collect::<Vec<_>>()
        };
        let time = |strategy: &str, structure: &str, ns: f64, ratios: [f64; 3]| {
            let row = row("time", strategy).set("accelerator", structure).set("ns_per_sample", ns);
            ["time_ratio_low", "time_ratio", "time_ratio_high"]
                .iter()
                .zip(ratios)
                .fold(row, |row, (column, ratio)| row.set(column, ratio))
        };
        let unknown = [f64::NAN; 3];
        let times = [
            time("mis", "bvh", 10.0, unknown),
            time("light", "bvh", 20.0, [1.5, 2.0, 2.5]),
            time("light", "grid", 25.0, [0.25, 0.5, 0.75]),
        ];
        let found = |rows: &[Row]| -> Vec<String> {
            let rows = convergence(rows, &times, 1, |parts| parts.join("/"));
            let columns =
                ["image_ns", "same_error_time_ratio_low", "same_error_time_ratio", "same_error_time_ratio_high"];
            rows.iter().map(|row| columns.map(|column| row.get(column)).join(" ")).collect()
        };
        let clear = [errors("mis", 0.5, true), errors("light", 1.0, true)].concat();
        assert_eq!(found(&clear), ["40   ", "80 6 8 10", "100 1 2 3"]);
        // An error that the reference's own reaches tells nothing.
        let unclear = [errors("mis", 0.5, false), errors("light", 1.0, true)].concat();
        assert_eq!(found(&unclear), ["40   ", "80   ", "100   "]);
    }
}
