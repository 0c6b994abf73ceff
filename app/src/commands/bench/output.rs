//! The output files of a benchmark.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

use raystep_kernels::Gpu;
use raystep_kernels::export::csv::{COLUMNS as PASSES_COLUMNS, PassesCsv};
use raystep_kernels::export::json::AdapterInfo;
use raystep_lab::bench::gate::{Gate, markdown};
use raystep_lab::bench::{Measured, RunRow, SCHEMA_VERSION, SummaryRow, write_rows};
use raystep_lab::tidy::package::{self, Resource};
use raystep_lab::{Machine, Subject};
use serde::Serialize;

use super::BenchArgs;
use crate::args::choices::{ChoiceArgs, Tuning};
use crate::commands::input::Input;
use crate::commands::json_text;
use crate::device::AboutClock;
use crate::error::Error;
use crate::output::{self, TargetFolder};
use crate::shard;

/// One row per configuration.
pub(super) const SUMMARY: &str = "summary.csv";
/// One row per timed run.
pub(super) const RUNS: &str = "runs.csv";
/// One row per pass.
const PASSES: &str = "passes.csv";
/// Machine and options.
const RUN: &str = "run.json";
/// A gate's result, for programs and for people.
const GATE: [&str; 2] = ["gate.json", "gate.md"];
/// All of them.
pub(super) const NAMES: [&str; 7] = [PASSES, SUMMARY, RUNS, RUN, package::FILE, GATE[0], GATE[1]];

/// The start of `run.json`, which identifies the folder.
const KIND: &str = "raystep bench";

/// `run.json`. The device is unknown where only other processes open it; the rows name it.
#[derive(Serialize)]
pub(super) struct About<'a> {
    kind: &'static str,
    schema_version: u32,
    raystep_version: &'static str,
    run_id: &'a str,
    command_line: Vec<String>,
    #[serde(flatten)]
    machine: Option<AboutMachine<'a>>,
    options: AboutOptions,
    scenes: Vec<AboutScene>,
    configurations: Vec<AboutConfiguration<'a>>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct AboutMachine<'a> {
    device: &'static str,
    device_reason: &'a str,
    adapter: Option<AdapterInfo>,
    clock: &'static str,
    /// Nanoseconds per tick of the adapter's timestamps; `null` if another clock is used.
    timestamp_period_ns: Option<f64>,
    /// Time of some work by the adapter's clock and by the host's; `null` if it has no clock.
    clock_check: Option<AboutClock>,
}

#[derive(Serialize)]
struct AboutOptions {
    accelerators: Vec<&'static str>,
    schedules: Vec<&'static str>,
    mappings: Vec<String>,
    traversals: Vec<&'static str>,
    integrators: Vec<&'static str>,
    replay: bool,
    /// The options that all runs share.
    #[serde(flatten)]
    tuning: ChoiceArgs<Tuning>,
    sizes: Vec<String>,
    rays: Vec<&'static str>,
    repeats: u32,
    warmups: u32,
    seed: u32,
    camera: BTreeMap<&'static str, String>,
    baseline: Option<String>,
    against: Option<String>,
    at_most: Option<f64>,
}

#[derive(Serialize)]
pub(super) struct AboutScene {
    name: String,
    path: String,
    files: usize,
    hash: String,
    triangles: usize,
}

impl AboutScene {
    pub(super) fn new(input: &Input, subject: &Subject) -> Self {
        Self {
            name: subject.scene.name.clone(),
            path: input.path.to_string_lossy().into_owned(),
            files: input.files.len(),
            hash: subject.hash.to_string(),
            triangles: subject.scene.triangles.len(),
        }
    }
}

#[derive(Serialize)]
struct AboutConfiguration<'a> {
    configuration: &'a str,
    /// Hashes of the composed WGSL, by kernel.
    shaders: &'a BTreeMap<&'static str, String>,
}

/// Refuses a folder whose files of these names are not from a benchmark.
pub(super) fn refuse_others(folder: &Path) -> Result<(), Error> {
    output::refuse_others(folder, &NAMES, "a benchmark", RUN, |bytes| {
        serde_json::from_slice::<serde_json::Value>(bytes).is_ok_and(|about| about["kind"] == KIND)
    })
}

/// The files of one benchmark.
pub(super) fn written(gate: &Option<Gate>, has_passes: bool) -> Vec<&'static str> {
    let passes = has_passes.then_some(PASSES);
    passes.into_iter().chain([SUMMARY, RUNS, RUN, package::FILE]).chain(gate.iter().flat_map(|_| GATE)).collect()
}

/// Files that an earlier benchmark may have left, and this one does not write.
pub(super) fn stale(has_gate: bool, is_against: bool, is_part: bool) -> Vec<String> {
    let gate = GATE.iter().filter(|_| !has_gate);
    let passes = is_against.then_some(PASSES);
    gate.copied().chain(passes).chain((!is_part).then_some(shard::FILE)).map(str::to_owned).collect()
}

/// Writes every file; `passes.csv` only if `has_passes`.
pub(super) fn write(
    folder: &TargetFolder,
    about: About<'_>,
    measured: &Measured,
    has_passes: bool,
    gate: Option<&Gate>,
) -> Result<(), Error> {
    let passes_columns: Vec<&str> = PASSES_COLUMNS.iter().map(String::as_str).collect();
    let mut files = vec![
        Resource { file: SUMMARY, what: "a configuration", columns: SummaryRow::COLUMNS },
        Resource { file: RUNS, what: "a timed run", columns: RunRow::COLUMNS },
    ];
    if has_passes {
        files.push(Resource {
            file: PASSES,
            what: "a pass of one run per configuration, beside the timed runs, in which every pass is timed",
            columns: &passes_columns,
        });
        folder.write(PASSES, |out| {
            let mut csv = PassesCsv::new(out)?;
            for run in &measured.details {
                for (index, pass) in run.passes.iter().enumerate() {
                    let parts = run.parts.get(index).map_or(&[][..], Vec::as_slice);
                    csv.write(&run.context, pass, parts, None)?;
                }
            }
            csv.finish()
        })?;
    }
    folder.write(SUMMARY, |out| write_rows(out, &measured.rows))?;
    folder.write(RUNS, |out| write_rows(out, &measured.runs))?;
    let schema = package::describe("raystep-bench", "raystep bench", &files);
    let mut texts = vec![(RUN, json_text(&about)?), (package::FILE, json_text(&schema)?)];
    if let Some(gate) = gate {
        texts.extend([(GATE[0], json_text(gate)?), (GATE[1], markdown(gate))]);
    }
    texts.into_iter().try_for_each(|(name, text)| folder.write(name, |out| out.write_all(text.as_bytes())))
}

impl<'a> About<'a> {
    pub(super) fn new(args: &BenchArgs, run_id: &'a str, notes: &'a [String], scenes: Vec<AboutScene>) -> Self {
        let command_line = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
        let path = |path: &Option<std::path::PathBuf>| path.as_ref().map(|path| path.to_string_lossy().into_owned());
        Self {
            kind: KIND,
            schema_version: SCHEMA_VERSION,
            raystep_version: env!("CARGO_PKG_VERSION"),
            run_id,
            command_line: std::iter::once("raystep".to_owned()).chain(command_line).collect(),
            machine: None,
            options: AboutOptions {
                accelerators: args.accelerators.iter().map(|a| a.name()).collect(),
                schedules: args.schedules.iter().map(|s| s.name()).collect(),
                mappings: args.mappings.iter().map(ToString::to_string).collect(),
                traversals: args.traversals.iter().map(|t| t.name()).collect(),
                integrators: args.integrators.iter().map(|i| i.name()).collect(),
                replay: args.replay,
                sizes: args.sizes.iter().map(ToString::to_string).collect(),
                rays: args.rays.iter().map(|k| k.name()).collect(),
                repeats: args.repeats(),
                warmups: args.warmups,
                tuning: args.tuning.clone(),
                seed: args.seed,
                camera: args.camera.words().into_iter().collect(),
                baseline: path(&args.baseline),
                against: path(&args.against),
                at_most: args.at_most,
            },
            scenes,
            configurations: Vec::new(),
            notes,
        }
    }

    /// The options that determine what is measured.
    pub(super) fn options(&self) -> &impl Serialize {
        &self.options
    }

    /// With the machine, and with the kernels of what was measured on it.
    pub(super) fn on(mut self, machine: &'a Machine, measured: &'a Measured) -> Self {
        self.machine = Some(AboutMachine {
            device: machine.kind(),
            device_reason: &machine.reason,
            adapter: machine.gpu().map(AdapterInfo::from),
            clock: machine.timer().name(),
            timestamp_period_ns: machine.gpu().and_then(Gpu::clock_period_ns),
            clock_check: machine.gpu().and_then(Gpu::clock_check).map(AboutClock::from),
        });
        let configuration = |run: &'a raystep_lab::bench::Details| AboutConfiguration {
            configuration: &run.context.configuration,
            shaders: &run.shaders,
        };
        self.configurations = measured.details.iter().map(configuration).collect();
        self
    }
}
