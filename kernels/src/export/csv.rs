//! `passes.csv`: one row per pass, RFC 4180, raw numbers with their unit in the column's name. Unknown values are
//! empty, never 0.
//!
//! | column | holds |
//! |---|---|
//! | `schema_version` | [`SCHEMA_VERSION`]; increased when the meaning of a column changes |
//! | `run_id`, `configuration` | identify one invocation of the command, and what was run in it |
//! | `scene` … `height_px` | what was run, and on which device |
//! | `repeat`, `is_warmup` | repetition, from 0, and whether it was only a warm-up |
//! | `pass_index` | index in the run, from 0 |
//! | `iteration` | iteration of the schedule's loop, from 1; 0 before the loop |
//! | `kernel` | the kernel that ran |
//! | `gpu_begin_ns`, `gpu_duration_ns` | since the run's first timed pass began, and of the pass, by `clock` |
//! | `cpu_encode_ns` | host time to record the pass |
//! | `rays_in` | rays in one of the kernel's states before the pass: those it worked on |
//! | `rays_out` | those of them that the pass moved to a state of another kernel; the rest stay for the next pass |
//! | `threads_launched` | by this pass, with or without a ray to work on; see [`Pass::threads_launched`] |
//! | `cells_visited`, `triangles_tested` | by this pass (with a BVH, nodes); known if counters were requested |
//! | `clock` | `gpu_timestamp` or `cpu_clock`; `host` if the device has no clock, or one that disagrees with the host's: only the whole run has a time; empty if nothing was timed |
//! | `clock_resolution_ns` | smallest step of that clock |
//! | `valid` | `true` if the timer gave a duration, `false` if it failed to, or the pass was too short to tell; empty if nothing was timed |
//! | `host_run_ns` | time of the whole run on the host's clock, including the wait for the device; known if `clock` is `host` |
//! | `duration_runs` | how often the pass was run to time it: `gpu_duration_ns` is the mean. Known, like the next two, if `clock` is coarse: it steps by 10 µs or more, as browsers' do |
//! | `duration_error_ns` | largest standard error of the duration by rounding |
//! | `duration_below_ns` | what the duration is certainly less than, also if the pass was too short to tell |

use std::io::Write;

use serde::{Serialize, Serializer};

use crate::renderer::Pass;

/// Version of the columns.
pub const SCHEMA_VERSION: u32 = 2;

/// The columns, in order.
pub const COLUMNS: [&str; 30] = [
    "schema_version",
    "run_id",
    "configuration",
    "scene",
    "accelerator",
    "schedule",
    "numerics",
    "adapter",
    "width_px",
    "height_px",
    "repeat",
    "is_warmup",
    "pass_index",
    "iteration",
    "kernel",
    "gpu_begin_ns",
    "gpu_duration_ns",
    "cpu_encode_ns",
    "rays_in",
    "rays_out",
    "threads_launched",
    "cells_visited",
    "triangles_tested",
    "clock",
    "clock_resolution_ns",
    "valid",
    "host_run_ns",
    "duration_runs",
    "duration_error_ns",
    "duration_below_ns",
];

/// Which clock timed the passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timer {
    /// The adapter's timestamps.
    GpuTimestamp {
        /// Nanoseconds between neighbouring values, see [`Gpu::clock_step_ns`](crate::Gpu::clock_step_ns).
        resolution_ns: f64,
    },
    /// The host's clock, around a twin.
    CpuClock {
        /// Smallest step seen.
        resolution_ns: Option<f64>,
    },
    /// The host's clock around the whole run: the device has none, or not a valid one, see [`crate::ClockCheck`].
    /// No pass has a time.
    Host {
        /// Smallest step seen.
        resolution_ns: Option<f64>,
    },
}

impl Timer {
    /// Its name in the column `clock`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::GpuTimestamp { .. } => "gpu_timestamp",
            Self::CpuClock { .. } => "cpu_clock",
            Self::Host { .. } => "host",
        }
    }

    /// Whether it times single passes, not only a run.
    #[must_use]
    pub fn times_passes(self) -> bool {
        !matches!(self, Self::Host { .. })
    }

    fn resolution_ns(self) -> Option<f64> {
        match self {
            Self::GpuTimestamp { resolution_ns } => Some(resolution_ns),
            Self::CpuClock { resolution_ns } | Self::Host { resolution_ns } => resolution_ns,
        }
    }
}

impl Serialize for Timer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// What all rows of a run have in common. Also in JSON, where a run is not repeated, under the columns' names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunContext {
    /// Identifies one invocation of the command, so that files can be joined.
    pub run_id: String,
    /// Identifies what was run, within `run_id`.
    pub configuration: String,
    /// The scene's name.
    pub scene: String,
    /// `--accelerator`
    pub accelerator: &'static str,
    /// `--schedule`
    pub schedule: &'static str,
    /// `--numerics`
    pub numerics: &'static str,
    /// The adapter's name, or `cpu`.
    pub adapter: String,
    /// Texels per row.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Repetition, from 0.
    #[serde(skip)]
    pub repeat: u32,
    /// Whether the repetition was only a warm-up.
    #[serde(skip)]
    pub is_warmup: bool,
    /// What timed the passes, if anything did.
    #[serde(rename = "clock")]
    pub timer: Option<Timer>,
    /// [`Renderer::host_ns`](crate::Renderer::host_ns) of the whole run; written if passes have no times.
    pub host_run_ns: Option<u64>,
}

/// What one pass added to the `counters` stream, summed over all rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassWork {
    /// Cells visited.
    pub cells_visited: u64,
    /// Triangles tested.
    pub triangles_tested: u64,
}

/// Number of rays that a pass moved out of its kernel's states: `rays_in` less those that are still there.
///
/// Only the kernel that runs moves rays, so nothing else can have entered those states meanwhile.
#[must_use]
pub fn rays_out(pass: &Pass) -> u32 {
    pass.rays_in.saturating_sub(pass.kernel.live(&pass.counts))
}

/// An RFC 4180 writer; lines end with CRLF.
#[must_use]
pub fn writer<W: Write>(out: W) -> ::csv::Writer<W> {
    ::csv::WriterBuilder::new().terminator(::csv::Terminator::CRLF).from_writer(out)
}

/// Writes a whole file: the column names, and rows with as many fields.
///
/// # Errors
/// If `out` fails.
pub fn write_file<'a>(
    out: impl Write,
    columns: &[&str],
    rows: impl IntoIterator<Item = &'a [String]>,
) -> std::io::Result<()> {
    let mut writer = writer(out);
    writer.write_record(columns)?;
    for row in rows {
        writer.write_record(row)?;
    }
    writer.flush()
}

/// A field; an unknown value is empty.
#[must_use]
pub fn known(value: Option<impl ToString>) -> String {
    value.map(|v| v.to_string()).unwrap_or_default()
}

/// Writes `passes.csv`.
pub struct PassesCsv<W: Write> {
    writer: ::csv::Writer<W>,
    /// Configuration, repetition and first timed pass's begin, for the rows being written.
    began: Option<(([String; 2], u32), u64)>,
}

impl<W: Write> PassesCsv<W> {
    /// Writes the column names.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn new(out: W) -> std::io::Result<Self> {
        let mut writer = writer(out);
        writer.write_record(COLUMNS)?;
        Ok(Self { writer, began: None })
    }

    /// When the run began, on its clock: at `begin_ns` if this is its first timed pass.
    fn run_began_ns(&mut self, run: &RunContext, begin_ns: u64) -> u64 {
        let key = ([run.run_id.clone(), run.configuration.clone()], run.repeat);
        match &self.began {
            Some((of, began)) if *of == key => *began,
            _ => self.began.insert((key, begin_ns)).1,
        }
    }

    /// Writes a pass; the passes of a run must come in order. `work` is known if counters were requested.
    ///
    /// # Errors
    /// If the output fails.
    pub fn write(&mut self, run: &RunContext, pass: &Pass, work: Option<PassWork>) -> std::io::Result<()> {
        // Times from an invalid clock are not written, even if they were read.
        let is_timed = run.timer.is_some_and(Timer::times_passes);
        let (begin_ns, duration_ns) = (pass.begin_ns.filter(|_| is_timed), pass.duration_ns.filter(|_| is_timed));
        let rounding = pass.rounding.filter(|_| is_timed);
        let since_start_ns = begin_ns.map(|begin| begin.saturating_sub(self.run_began_ns(run, begin)));
        let row: [String; COLUMNS.len()] = [
            SCHEMA_VERSION.to_string(),
            run.run_id.clone(),
            run.configuration.clone(),
            run.scene.clone(),
            run.accelerator.into(),
            run.schedule.into(),
            run.numerics.into(),
            run.adapter.clone(),
            run.width_px.to_string(),
            run.height_px.to_string(),
            run.repeat.to_string(),
            run.is_warmup.to_string(),
            pass.index.to_string(),
            pass.iteration.to_string(),
            pass.kernel.name().into(),
            known(since_start_ns),
            known(duration_ns),
            String::new(),
            pass.rays_in.to_string(),
            rays_out(pass).to_string(),
            pass.threads_launched.to_string(),
            known(work.map(|w| w.cells_visited)),
            known(work.map(|w| w.triangles_tested)),
            known(run.timer.map(Timer::name)),
            known(run.timer.and_then(Timer::resolution_ns)),
            known(run.timer.map(|_| duration_ns.is_some())),
            known(run.host_run_ns.filter(|_| run.timer.is_some_and(|timer| !timer.times_passes()))),
            known(rounding.map(|rounding| rounding.runs)),
            known(rounding.map(|rounding| rounding.error_ns)),
            known(rounding.map(|rounding| rounding.below_ns)),
        ];
        Ok(self.writer.write_record(row)?)
    }

    /// Writes what is still buffered.
    ///
    /// # Errors
    /// If the output fails.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}

#[cfg(test)]
mod tests;
