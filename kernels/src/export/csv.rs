//! `passes.csv`: one row per pass, or per part of a pass that is drawn, RFC 4180, raw numbers with their unit in the
//! column's name. Unknown values are empty, never 0. Sums over all rows are those of the run, of all its samples; only the
//! durations of parts that are drawn add up to less, since there is time between them.
//!
//! | column | holds |
//! |---|---|
//! | `schema_version` | [`SCHEMA_VERSION`]; increased when the meaning of a column changes |
//! | `run_id`, `configuration` | identify one invocation of the command, and what was run in it |
//! | `scene` … `adapter` | what was run, and on which device |
//! | `width_px`, `height_px` | size of the image that the rays are from; of input rays, of the image in which they are arranged; in a program without rays, of the texture of its main elements |
//! | `repeat`, `is_warmup` | repetition of the run, from 0, and whether it was only a warm-up |
//! | `pass_index` | index in the run, from 0 |
//! | `sample` | sample of every pixel, from 0: see [`Pass::sample`] |
//! | `iteration` | iterations of the schedule's loop that have begun in this sample: see [`Pass::iteration`] |
//! | `kernel` | the kernel that ran |
//! | `begin_ns` | when the pass began, since the run's first timed pass began, by `clock`; empty from the pass on at which that clock was set back |
//! | `duration_ns` | how long the pass took, by `clock` |
//! | `encode_ns` | how long the host took to record the pass's commands, by its own clock; empty on the CPU, which records none |
//! | `rays_in` | rays in one of the kernel's states before the pass: those it worked on; in a program without rays, elements |
//! | `rays_out` | those of them that the pass moved to a state of another kernel; the rest stay for the next pass. Empty for a kernel whose elements have no states |
//! | `threads_launched` | by this pass, with or without a ray to work on; see [`Pass::threads_launched`] |
//! | `cells_visited`, `triangles_tested` | by this pass (with a BVH, nodes); known if counters were requested |
//! | `repeated_tests` | those of the pass's tests whose triangle the ray had already met in an earlier cell; also empty with a BVH, and where a pass takes several steps |
//! | `clock` | of `begin_ns` and `duration_ns`: `gpu_timestamp` or `cpu_clock`; `host` if the device has no clock, or one that disagrees with the host's: only the whole run has a time; empty if nothing was timed |
//! | `clock_resolution_ns` | smallest step of that clock |
//! | `valid` | `true` if the timer gave a duration, `false` if it failed to, or the pass was too short to tell; empty if nothing was timed |
//! | `host_run_ns` | time of all passes of the run on the host's clock, including waits for the device, without what was done between submissions |
//! | `duration_runs` | how often the pass was run to time it: `duration_ns` is the mean. Known, like the next two, if `clock` is coarse: it steps by 10 µs or more, as browsers' do |
//! | `duration_error_ns` | largest standard error of the duration by rounding |
//! | `duration_below_ns` | what the duration is certainly less than, also if the pass was too short to tell |
//! | `mapping` | how kernels are mapped to the GPU: `compute`, or [`fragment`](crate::options::mapping::Mapping) and its choices |
//! | `draw` | with fragment programs, the row's part of the pass, from 0: copies of streams, the draw of depths, the kernel's draws. Begin, duration and threads are the part's; what belongs to the whole pass (rays, counters, time to record) is in the row of its last part |
//! | `targets` | the streams that the part writes, separated by spaces; `depth` for depths |
//! | `fragments_run` | fragments for which the draw ran its program, by the device's pipeline statistics, if they were asked for |
//! | `bytes_copied` | bytes that the part copies |
//! | `traversal` | how rays walk through a uniform grid: `amanatides-woo` or `3d-dda` |
//! | `loops` | turns of the schedule's loops that the pass is in, from 0, outermost loop first, separated by spaces: see [`Pass::loops`]. Of paths, the turn after that of the loop over samples is the bounce |
//! | `scene_data` | where kernels read the lists of the scene: `buffers` or `textures` |
//! | `integrator` | the light that a pixel receives: `local`, `shadows`; options that come later are columns by their rows |

mod drawn;
mod writer;

use std::io::Write;
use std::sync::LazyLock;

use serde::{Serialize, Serializer};

use crate::options::Choices;
use crate::options::rows::{self, ROWS};
use crate::renderer::{CounterSums, Pass};
pub use drawn::DrawnPart;
pub use writer::{Writer, known, write_file, writer};

/// Version of the columns.
pub const SCHEMA_VERSION: u32 = 4;

/// The columns, in order. Options that are columns and not named here come last, so that older columns keep their places.
pub static COLUMNS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let mut columns: Vec<String> = FIRST_COLUMNS.map(String::from).into();
    columns.extend(later_options().map(rows::Row::key));
    columns
});

fn later_options() -> impl Iterator<Item = &'static rows::Row> {
    ROWS.iter().filter(|row| row.is_column && !FIRST_COLUMNS.contains(&row.key().as_str()))
}

const FIRST_COLUMNS: [&str; 41] = [
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
    "sample",
    "iteration",
    "kernel",
    "begin_ns",
    "duration_ns",
    "encode_ns",
    "rays_in",
    "rays_out",
    "threads_launched",
    "cells_visited",
    "triangles_tested",
    "repeated_tests",
    "clock",
    "clock_resolution_ns",
    "valid",
    "host_run_ns",
    "duration_runs",
    "duration_error_ns",
    "duration_below_ns",
    "mapping",
    "draw",
    "targets",
    "fragments_run",
    "bytes_copied",
    "traversal",
    "loops",
    "scene_data",
    "integrator",
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
    /// The options, with the acceleration structure that the run has, also if it was chosen automatically.
    #[serde(flatten, serialize_with = "rows::serialize_columns")]
    pub choices: Choices,
    /// The adapter's name, or `cpu`.
    pub adapter: String,
    /// Pixels per row of the image that the rays are from, or of the one in which input rays are arranged; in a program
    /// without rays, texels per row of its main elements. `None` if it is not known.
    pub width_px: Option<u32>,
    /// Its rows.
    pub height_px: Option<u32>,
    /// Repetition, from 0.
    #[serde(skip)]
    pub repeat: u32,
    /// Whether the repetition was only a warm-up.
    #[serde(skip)]
    pub is_warmup: bool,
    /// What timed the passes, if anything did.
    #[serde(rename = "clock")]
    pub timer: Option<Timer>,
    /// [`Renderer::host_ns`](crate::Renderer::host_ns) of the whole run.
    pub host_run_ns: Option<u64>,
}

/// Number of rays that a pass moved out of its kernel's states: `rays_in` less those that are still there. `None` for a
/// kernel that works on all elements, whatever their state.
///
/// Only the kernel that runs moves rays, so nothing else can have entered those states meanwhile.
#[must_use]
pub fn rays_out(pass: &Pass) -> Option<u32> {
    let has_states = !pass.kernel.takes().is_empty();
    has_states.then(|| pass.rays_in.saturating_sub(pass.kernel.live(&pass.counts)))
}

/// A row to be written.
#[derive(Clone, Copy)]
struct Row<'a> {
    pass: &'a Pass,
    part: Option<(usize, &'a DrawnPart)>,
    /// Whether it has what belongs to the whole pass.
    is_last: bool,
    work: Option<CounterSums>,
    begin_ns: Option<u64>,
    duration_ns: Option<u64>,
}

/// The begins of a run's passes on their clock.
#[derive(Clone, Copy)]
struct Begins {
    first: u64,
    latest: u64,
    /// Whether the clock was set back: how much later than the first anything is since then is not known.
    is_set_back: bool,
}

impl Begins {
    /// Time since the first begin, if that is known.
    fn since_first(&mut self, begin_ns: u64) -> Option<u64> {
        self.is_set_back |= begin_ns < self.latest;
        self.latest = begin_ns;
        (!self.is_set_back).then(|| begin_ns - self.first)
    }
}

/// Writes `passes.csv`.
pub struct PassesCsv<W: Write> {
    writer: Writer<W>,
    /// Run, configuration and repetition of the rows being written, and the begins of their passes.
    began: Option<(([String; 2], u32), Begins)>,
}

impl<W: Write> PassesCsv<W> {
    /// Writes the column names.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn new(out: W) -> std::io::Result<Self> {
        let mut writer = writer(out);
        writer.write_record(COLUMNS.iter())?;
        Ok(Self { writer, began: None })
    }

    /// Time since the run's first timed pass began, if that is known.
    fn since_start_ns(&mut self, run: &RunContext, begin_ns: u64) -> Option<u64> {
        let key = ([run.run_id.clone(), run.configuration.clone()], run.repeat);
        if self.began.as_ref().is_none_or(|(of, _)| *of != key) {
            self.began = Some((key, Begins { first: begin_ns, latest: begin_ns, is_set_back: false }));
        }
        self.began.as_mut().and_then(|(_, begins)| begins.since_first(begin_ns))
    }

    /// Writes a pass; the passes of a run must come in order. `work` is known if counters were requested. `parts` are those
    /// of a pass that is drawn.
    ///
    /// # Errors
    /// If the output fails.
    pub fn write(
        &mut self,
        run: &RunContext,
        pass: &Pass,
        parts: &[DrawnPart],
        work: Option<CounterSums>,
    ) -> std::io::Result<()> {
        let (begin_ns, duration_ns) = (pass.begin_ns, pass.duration_ns);
        let row = Row { pass, part: None, is_last: true, work, begin_ns, duration_ns };
        if parts.is_empty() {
            return self.write_row(run, &row);
        }
        for (index, part) in parts.iter().enumerate() {
            let is_last = index + 1 == parts.len();
            let (begin_ns, duration_ns) = (part.time.begin_ns, part.time.duration_ns);
            self.write_row(run, &Row { part: Some((index, part)), is_last, begin_ns, duration_ns, ..row })?;
        }
        Ok(())
    }

    fn write_row(&mut self, run: &RunContext, row: &Row<'_>) -> std::io::Result<()> {
        let Row { pass, part, is_last, .. } = *row;
        let work = row.work.filter(|_| is_last);
        // Times from an invalid clock are not written, even if they were read.
        let is_timed = run.timer.is_some_and(Timer::times_passes);
        let (begin_ns, duration_ns) = (row.begin_ns.filter(|_| is_timed), row.duration_ns.filter(|_| is_timed));
        let rounding = pass.rounding.filter(|_| is_timed && part.is_none());
        let since_start_ns = begin_ns.and_then(|begin_ns| self.since_start_ns(run, begin_ns));
        let threads = part.map_or(pass.threads_launched, |(_, part)| part.fragments_drawn);
        let option = |name: &str| rows::Row::named(name).map_or_else(String::new, |row| recorded(row, run));
        let first: [String; FIRST_COLUMNS.len()] = [
            SCHEMA_VERSION.to_string(),
            run.run_id.clone(),
            run.configuration.clone(),
            run.scene.clone(),
            option("accelerator"),
            option("schedule"),
            option("numerics"),
            run.adapter.clone(),
            known(run.width_px),
            known(run.height_px),
            run.repeat.to_string(),
            run.is_warmup.to_string(),
            pass.index.to_string(),
            pass.sample.to_string(),
            pass.iteration.to_string(),
            pass.kernel.name().into(),
            known(since_start_ns),
            known(duration_ns),
            known(pass.encode_ns.filter(|_| is_last)),
            known(is_last.then_some(pass.rays_in)),
            known(rays_out(pass).filter(|_| is_last)),
            threads.to_string(),
            known(work.map(|w| w.cells_visited)),
            known(work.map(|w| w.triangles_tested)),
            known(work.and_then(|w| w.repeated_tests)),
            known(run.timer.map(Timer::name)),
            known(run.timer.and_then(Timer::resolution_ns)),
            known(run.timer.map(|_| duration_ns.is_some())),
            known(run.host_run_ns),
            known(rounding.map(|rounding| rounding.runs)),
            known(rounding.map(|rounding| rounding.error_ns)),
            known(rounding.map(|rounding| rounding.below_ns)),
            option("mapping"),
            known(part.map(|(index, _)| index)),
            part.map(|(_, part)| part.targets.clone()).unwrap_or_default(),
            known(part.and_then(|(_, part)| part.time.fragments)),
            known(part.map(|(_, part)| part.bytes_copied)),
            option("traversal"),
            pass.loops_text(),
            option("scene-data"),
            option("integrator"),
        ];
        let row = first.into_iter().chain(later_options().map(|option| recorded(option, run)));
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

fn recorded(option: &rows::Row, run: &RunContext) -> String {
    option.recorded(&run.choices).map_or_else(String::new, |value| value.to_string())
}

#[cfg(test)]
mod tests;
