//! The output files of a benchmark.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

use raystep_kernels::export::csv::PassesCsv;
use raystep_kernels::export::json::AdapterInfo;
use raystep_kernels::{Gpu, ScheduleKind};
use raystep_lab::bench::{Measured, SCHEMA_VERSION, SEED, Wanted, grid_text, tuning_text, write_summary};
use raystep_lab::statistics::PERCENTILES;
use raystep_lab::{Machine, Subject};
use serde::Serialize;

use super::BenchArgs;
use crate::commands::input::Input;
use crate::device::AboutClock;
use crate::error::Error;
use crate::output::{self, TargetFolder};

/// One row per configuration.
pub(super) const SUMMARY: &str = "summary.csv";
/// One row per pass.
const PASSES: &str = "passes.csv";
/// Machine and options.
const RUN: &str = "run.json";
/// All of them.
pub(super) const NAMES: [&str; 3] = [PASSES, SUMMARY, RUN];

/// The start of `run.json`, which identifies the folder.
const KIND: &str = "raystep bench";

#[derive(Serialize)]
struct About<'a> {
    kind: &'static str,
    schema_version: u32,
    raystep_version: &'static str,
    run_id: &'a str,
    command_line: Vec<String>,
    device: &'static str,
    device_reason: &'a str,
    adapter: Option<AdapterInfo>,
    timer_source: &'static str,
    /// Nanoseconds per tick of the adapter's timestamps; `null` if another clock is used.
    timestamp_period_ns: Option<f64>,
    /// Time of some work by the adapter's clock and by the host's; `null` if it has no clock.
    clock_check: Option<AboutClock>,
    options: AboutOptions,
    /// Definitions of the rays.
    percentiles: &'static str,
    scenes: Vec<AboutScene>,
    configurations: Vec<AboutConfiguration<'a>>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct AboutOptions {
    accelerators: Vec<&'static str>,
    schedules: Vec<&'static str>,
    numerics: &'static str,
    sizes: Vec<String>,
    rays: Vec<&'static str>,
    repeats: u32,
    warmups: u32,
    grid: String,
    keep_all: bool,
    tuning: String,
    seed: u32,
    baseline: Option<String>,
}

#[derive(Serialize)]
struct AboutScene {
    name: String,
    path: String,
    files: usize,
    hash: String,
    triangles: usize,
}

#[derive(Serialize)]
struct AboutConfiguration<'a> {
    run_id: &'a str,
    /// Hashes of the composed WGSL, by kernel.
    shaders: &'a BTreeMap<&'static str, String>,
}

/// Refuses a folder whose files of these names are not from a benchmark.
pub(super) fn refuse_others(folder: &Path) -> Result<(), Error> {
    output::refuse_others(folder, &NAMES, "a benchmark", RUN, |bytes| {
        serde_json::from_slice::<serde_json::Value>(bytes).is_ok_and(|about| about["kind"] == KIND)
    })
}

/// Writes every file.
pub(super) fn write(
    folder: &TargetFolder,
    args: &BenchArgs,
    wanted: &Wanted,
    machine: &Machine,
    inputs: &[Input],
    subjects: &[Subject],
    measured: &Measured,
) -> Result<(), Error> {
    folder.write(PASSES, |out| {
        let mut csv = PassesCsv::new(out)?;
        for run in &measured.details {
            run.passes.iter().try_for_each(|pass| csv.write(&run.context, pass, None))?;
        }
        csv.finish()
    })?;
    folder.write(SUMMARY, |out| write_summary(out, &measured.rows))?;
    let scenes = inputs.iter().zip(subjects).map(|(input, subject)| AboutScene {
        name: subject.scene.name.clone(),
        path: input.path.to_string_lossy().into_owned(),
        files: input.files.len(),
        hash: subject.hash.to_string(),
        triangles: subject.scene.triangles.len(),
    });
    let text = crate::commands::json_text(&about(args, wanted, machine, scenes.collect(), measured))?;
    folder.write(RUN, |out| out.write_all(text.as_bytes()))
}

fn about<'a>(
    args: &BenchArgs,
    wanted: &Wanted,
    machine: &'a Machine,
    scenes: Vec<AboutScene>,
    measured: &'a Measured,
) -> About<'a> {
    let command_line = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    let configurations = measured.details.iter();
    About {
        kind: KIND,
        schema_version: SCHEMA_VERSION,
        raystep_version: env!("CARGO_PKG_VERSION"),
        run_id: &measured.run_id,
        command_line: std::iter::once("raystep".to_owned()).chain(command_line).collect(),
        device: machine.kind(),
        device_reason: &machine.reason,
        adapter: machine.gpu().map(AdapterInfo::from),
        timer_source: machine.timer().name(),
        timestamp_period_ns: machine.gpu().and_then(Gpu::clock_period_ns),
        clock_check: machine.gpu().and_then(Gpu::clock_check).map(AboutClock::from),
        options: AboutOptions {
            accelerators: args.accelerators.iter().map(|a| a.name()).collect(),
            schedules: args.schedules.iter().map(|s| s.name()).collect(),
            numerics: args.tuning.numerics.name(),
            sizes: args.sizes.iter().map(ToString::to_string).collect(),
            rays: args.rays.iter().map(|k| k.name()).collect(),
            repeats: args.repeats,
            warmups: args.warmups,
            grid: grid_text(args.tuning.grid),
            keep_all: args.tuning.keep_all,
            tuning: tuning_text(&wanted.tuning, args.schedules.contains(&ScheduleKind::Compact)),
            seed: SEED,
            baseline: args.baseline.as_ref().map(|path| path.to_string_lossy().into_owned()),
        },
        percentiles: PERCENTILES,
        scenes,
        configurations: configurations
            .map(|run| AboutConfiguration { run_id: &run.context.run_id, shaders: &run.shaders })
            .collect(),
        notes: &measured.notes,
    }
}
