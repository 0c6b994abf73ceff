//! What sections share: a scene on a device, time limits, and interleaved runs.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use raystep_kernels::export::csv::Timer;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Accelerator, GridSize, Options, Progress, RaySource, Renderer, ScheduleKind, let_others_run};
use web_time::Instant;

use super::methods::Method;
use super::page::Part;
use super::record::Record;
use crate::configuration::Configuration;
use crate::meter::{Ended, Meter};
use crate::rays::file::RaysFile;
use crate::reporter::Reporter;
use crate::stiff::Start;
use crate::subject::{Size, Subject};
use crate::tidy::Row;
use crate::{Error, Machine};

/// Time limit of one run.
const LONGEST_RUN: Duration = Duration::from_secs(20);

/// Share of a section's time that one run may take.
const A_RUN_TAKES: f64 = 0.25;

/// Pass limit of one run: with the paper's numerics a walk may never end.
const MOST_PASSES: usize = 100_000;

/// A scene to report on.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    pub(super) subject: &'a Subject,
    pub(super) meter: &'a Meter,
    pub(super) size: Size,
    /// The resolution for sections that do not vary it.
    pub(super) grid: GridSize,
    pub(super) is_quick: bool,
    /// Time of this section for the scene; `None` without a limit.
    pub(super) time: Option<Duration>,
    /// When the section began.
    pub(super) begin: Instant,
    /// What to measure of what can be chosen.
    pub(super) only: &'a Only,
    /// How many seeds to measure where a section varies them.
    pub(super) seeds: u32,
    pub(super) reporter: &'a dyn Reporter,
    /// The section that is measured.
    pub(super) section: &'static str,
    /// Runs and rays of all sections.
    pub(super) record: &'a Record,
    /// Results of other programs.
    pub(super) methods: &'a [Method],
    /// Rays of another program.
    pub(super) rays: Option<&'a RaysFile>,
    /// The families of stiff scenes.
    pub(super) stiff: Option<&'a Start>,
}

/// Restricts what is measured.
#[derive(Clone, Debug, Default)]
pub struct Only {
    /// These structures; all if it is empty.
    pub accelerators: Vec<Accelerator>,
    /// These schedules; all if it is empty.
    pub schedules: Vec<ScheduleKind>,
}

impl Only {
    /// Whether a structure is measured.
    #[must_use]
    pub fn has(&self, accelerator: Accelerator) -> bool {
        self.accelerators.is_empty() || self.accelerators.contains(&accelerator)
    }

    /// Whether a schedule is measured.
    #[must_use]
    pub fn has_schedule(&self, schedule: ScheduleKind) -> bool {
        self.schedules.is_empty() || self.schedules.contains(&schedule)
    }
}

/// A structure with a schedule and numerics, in words.
pub(super) fn in_words(Configuration { accelerator, schedule, numerics, .. }: &Configuration) -> String {
    format!("{accelerator} {schedule} {numerics}")
}

/// The same as a configuration's id.
pub(super) fn id(work: &Work<'_>, Configuration { accelerator, schedule, numerics, .. }: &Configuration) -> String {
    work.configuration(&[accelerator.name(), schedule.name(), numerics.name()])
}

/// Everything is measured.
static ALL: Only = Only { accelerators: Vec::new(), schedules: Vec::new() };

impl<'a> Work<'a> {
    /// A scene without a report around it: no limit, nothing from other programs, and no image.
    pub(super) fn alone(
        subject: &'a Subject,
        meter: &'a Meter,
        section: &'static str,
        record: &'a Record,
        reporter: &'a dyn Reporter,
    ) -> Self {
        Self {
            subject,
            meter,
            size: Size { width: 0, height: 0 },
            grid: GridSize::Auto,
            is_quick: false,
            time: None,
            begin: Instant::now(),
            only: &ALL,
            seeds: 1,
            reporter,
            section,
            record,
            methods: &[],
            rays: None,
            stiff: None,
        }
    }
}

/// A plan that can be started many times.
pub(super) struct Planned {
    pub(super) plan: Arc<Plan>,
    data: Arc<SceneData>,
    /// Seconds for planning: mostly for building the structure.
    pub(super) build_s: f64,
}

impl Planned {
    pub(super) fn plan(&self) -> Arc<Plan> {
        self.plan.clone()
    }

    pub(super) fn data(&self) -> &SceneData {
        &self.data
    }
}

/// A renderer that is ready to run, with the times to build it.
pub(super) struct Built {
    pub(super) renderer: Renderer,
    /// Seconds for planning: mostly for building the structure.
    pub(super) build_s: f64,
    /// Seconds for allocating, uploading and compiling, by the host's clock: where a thread has other tasks, what they
    /// did meanwhile is included.
    pub(super) start_s: f64,
}

impl Work<'_> {
    /// The machine that measurements run on.
    pub(super) fn machine(&self) -> &Machine {
        &self.meter.machine
    }

    /// A row with the columns that identify report, scene and adapter.
    pub(super) fn row(&self, columns: &'static [&'static str]) -> Row {
        self.record.row(columns, &self.subject.scene.name, self.subject.hash, &self.machine().name())
    }

    /// Seed of all random numbers.
    pub(super) fn seed(&self) -> u32 {
        self.record.seed
    }

    /// The id of a configuration of this section.
    pub(super) fn configuration(&self, parts: &[&str]) -> String {
        std::iter::once(self.section).chain(parts.iter().copied()).collect::<Vec<_>>().join("/").replace(' ', "-")
    }

    /// One ray through the centre of each pixel.
    pub(super) fn camera_rays(&self) -> RaySource {
        self.subject.camera_rays(self.size)
    }

    /// The grid's resolution, for a grid.
    pub(super) fn grid_of(&self, accelerator: Accelerator) -> GridSize {
        if accelerator == Accelerator::Grid { self.grid } else { GridSize::Auto }
    }

    /// Waits for a future of this machine: for sections that block.
    pub(super) fn wait<T>(&self, future: impl Future<Output = T>) -> T {
        self.machine().wait(future)
    }

    /// Chooses between the quick and the normal amount.
    pub(super) fn either<T>(&self, quick: T, normal: T) -> T {
        if self.is_quick { quick } else { normal }
    }

    /// Whether this share of the section's time is over.
    pub(super) fn is_past(&self, share: f64) -> bool {
        self.time.is_some_and(|time| self.begin.elapsed() > time.mul_f64(share))
    }

    /// What is left of the section's time.
    pub(super) fn left(&self) -> Option<Duration> {
        Some(self.time?.saturating_sub(self.begin.elapsed()))
    }

    /// The shorter of this time and what is left.
    pub(super) fn at_most(&self, time: Duration) -> Duration {
        self.left().map_or(time, |left| left.min(time))
    }

    /// The section's time, in words.
    pub(super) fn time_in_words(&self) -> String {
        self.time.map_or_else(String::new, |time| format!("{} s", time.as_secs_f64()))
    }

    /// The note on what was left out when the section's time was over; `None` if nothing was.
    pub(super) fn left_out(&self, names: &[String]) -> Option<String> {
        let time = self.time_in_words();
        (!names.is_empty()).then(|| format!("left out, to stay within {time} (--seconds): {}", names.join(", ")))
    }

    /// Reports the next stage of the section.
    pub(super) fn stage(&self, what: &str) {
        self.reporter.stage(&format!("{}: {what}", self.subject.scene.name));
    }

    /// The clock of all times.
    pub(super) fn clock(&self) -> &'static str {
        self.machine().timer().name()
    }

    /// The same clock, in words.
    pub(super) fn clock_in_words(&self) -> &'static str {
        match self.machine().timer() {
            Timer::GpuTimestamp { .. } => "by the adapter's own timestamps",
            Timer::CpuClock { .. } => "by the host's clock around each pass on the CPU",
            Timer::Host { .. } => "by the host's clock, including waits for the adapter: it has no valid timestamps",
        }
    }

    /// Plans and builds; kernels are composed anew.
    pub(super) fn plan(&self, options: &Options) -> Result<Planned, Error> {
        self.is_wanted()?;
        self.machine().forget_kernels();
        let begin = Instant::now();
        let (plan, data) = Plan::new(&self.subject.scene, options, &self.machine().limits())?;
        Ok(Planned { plan: Arc::new(plan), data: Arc::new(data), build_s: begin.elapsed().as_secs_f64() })
    }

    /// Allocates, uploads and compiles anew; the driver may cache what it compiles. On a GPU, the caller chooses
    /// whether to time whole runs or passes; on the CPU the total is the sum of the passes.
    pub(super) async fn start(&self, planned: &Planned, options: &Options) -> Result<Built, Error> {
        // Planning was done in one go.
        let_others_run().await;
        let mut options = options.clone();
        options.timings |= self.machine().gpu().is_none();
        self.machine().forget_kernels();
        let begin = Instant::now();
        let Planned { plan, data, build_s } = planned;
        let renderer = Renderer::from_plan(plan.clone(), data.clone(), &options, &self.machine().device).await?;
        self.machine().settle().await;
        Ok(Built { renderer, build_s: *build_s, start_s: begin.elapsed().as_secs_f64() })
    }

    /// Plans and starts.
    pub(super) async fn build(&self, options: &Options) -> Result<Built, Error> {
        self.start(&self.plan(options)?, options).await
    }

    /// What was found, or nothing and a note with this name; an error if the device itself has failed.
    pub(super) fn noted<T>(&self, part: &mut Part, name: &str, found: Result<T, Error>) -> Result<Option<T>, Error> {
        let Err(error) = found else { return Ok(found.ok()) };
        self.can_go_on()?;
        part.notes.push(format!("{name}: {}", self.reporter.explain(&error)));
        Ok(None)
    }

    /// Whether to continue after an error: not if the device itself has failed, or if everything is cancelled.
    pub(super) fn can_go_on(&self) -> Result<(), Error> {
        self.is_wanted()?;
        Ok(self.machine().health()?)
    }

    /// An error if everything is cancelled.
    pub(super) fn is_wanted(&self) -> Result<(), Error> {
        if self.reporter.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Runs to the end, or until a limit is reached.
    pub(super) async fn run(&self, renderer: &mut Renderer) -> Result<Ended, Error> {
        let longest = self.time.map_or(LONGEST_RUN, |time| LONGEST_RUN.min(time.mul_f64(A_RUN_TAKES)));
        let is_over = |progress: &Progress, spent: Duration| {
            spent > longest || progress.passes >= MOST_PASSES || self.reporter.is_cancelled()
        };
        let watch = |progress: &Progress, spent: Duration| match is_over(progress, spent) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let ended = self.meter.run(renderer, watch).await?;
        self.is_wanted()?;
        Ok(ended)
    }
}
