//! What sections share: a scene on a device, time limits, and interleaved runs.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use raystep_kernels::export::csv::Timer;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Accelerator, GridSize, Options, Progress, RaySource, Renderer, let_others_run};
use web_time::Instant;

use super::methods::Method;
use super::record::{RUN_COLUMNS, Record};
use crate::meter::{Ended, Meter, Rounds, Time, Turns};
use crate::rays::file::RaysFile;
use crate::reporter::Reporter;
use crate::statistics::interval::{self, Interval};
use crate::statistics::median;
use crate::stiff::Start;
use crate::subject::{Size, Subject};
use crate::tidy::{Row, fill};
use crate::{Error, Machine};

/// Time limit of one run.
const LONGEST_RUN: Duration = Duration::from_secs(20);

/// Time limit for the repeats of one configuration, after the first [`interval::FEWEST`].
const REPEATS_TAKE: Duration = Duration::from_secs(1);

/// Pass limit of one run: with the paper's numerics a walk may never end.
const MOST_PASSES: usize = 100_000;

/// Tests per pass without an accelerator, for schedules that take several: the list holds the whole scene.
pub(super) const TESTS_PER_PASS: u32 = 128;

/// A scene to report on.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    pub(super) subject: &'a Subject,
    pub(super) meter: &'a Meter,
    pub(super) size: Size,
    /// The resolution for sections that do not vary it.
    pub(super) grid: GridSize,
    pub(super) is_quick: bool,
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

/// Times of a configuration.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    /// One per round; `None` if the clock had no valid time.
    runs: Vec<Option<f64>>,
    /// Whether a run was stopped: then there are no times, and the streams are incomplete.
    pub(super) is_given_up: bool,
}

impl Times {
    /// Times that were measured otherwise: one per round.
    pub(super) fn of(runs: Vec<Option<f64>>) -> Self {
        Self { runs, is_given_up: false }
    }

    fn known(&self) -> Vec<f64> {
        fill::known(&self.runs)
    }

    /// The number of runs with a time.
    pub(super) fn runs(&self) -> usize {
        self.known().len()
    }

    /// The number of rounds.
    pub(super) fn rounds(&self) -> usize {
        self.runs.len()
    }

    /// The median.
    pub(super) fn median(&self) -> Option<f64> {
        median(&self.known())
    }

    /// The times in the rounds that satisfy a condition.
    pub(super) fn in_rounds(&self, is_wanted: impl Fn(usize) -> bool) -> Self {
        let wanted = self.runs.iter().enumerate().map(|(round, time)| time.filter(|_| is_wanted(round)));
        Self { runs: wanted.collect(), is_given_up: self.is_given_up }
    }

    /// Its runs with the other's runs of the same rounds, where both have a time.
    pub(super) fn pairs<'t>(&'t self, to: &'t Self) -> impl Iterator<Item = (f64, f64)> + 't {
        fill::pairs(&self.runs, &to.runs)
    }

    /// How much longer each run took than the other's run of the same round, in nanoseconds.
    pub(super) fn differences(&self, to: &Self) -> Vec<f64> {
        self.pairs(to).map(|(a, b)| a - b).collect()
    }

    /// The median ratio to the other's runs of the same rounds, with its interval if there are enough.
    pub(super) fn ratio(&self, to: &Self, seed: u32) -> Option<(f64, Option<Interval>)> {
        fill::ratio_of(&self.runs, &to.runs, seed)
    }

    /// Fills the columns of times.
    pub(super) fn fill(&self, row: Row, seed: u32) -> Row {
        fill::times(row, &self.runs, seed)
    }

    /// Fills the columns of the ratio to another configuration.
    pub(super) fn fill_ratio(&self, to: &Self, name: &str, row: Row, seed: u32) -> Row {
        fill::ratio(row, &self.runs, &to.runs, name, seed)
    }
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

    /// The text of an error in a note.
    pub(super) fn explain(&self, error: &Error) -> String {
        self.reporter.explain(error)
    }

    /// Whether to continue after an error: not if the device itself has failed, or if everything is cancelled.
    pub(super) fn can_go_on(&self) -> Result<(), Error> {
        self.is_wanted()?;
        Ok(self.machine().gpu().map_or(Ok(()), |gpu| gpu.health())?)
    }

    /// An error if everything is cancelled.
    pub(super) fn is_wanted(&self) -> Result<(), Error> {
        if self.reporter.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Runs to the end, or until a limit is reached.
    pub(super) async fn run(&self, renderer: &mut Renderer) -> Result<Ended, Error> {
        let is_over = |progress: &Progress, spent: Duration| {
            spent > LONGEST_RUN || progress.passes >= MOST_PASSES || self.reporter.is_cancelled()
        };
        let watch = |progress: &Progress, spent: Duration| match is_over(progress, spent) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let ended = self.meter.run(renderer, watch).await?;
        self.is_wanted()?;
        Ok(ended)
    }

    /// The time of a run by the clock that [times passes](Self::clock); `None` if it had no valid time.
    pub(super) fn ns(&self, time: Time) -> Option<f64> {
        match self.machine().timer().times_passes() {
            true => time.device_ns.map(|ns| ns as f64),
            false => Some(time.wall_ns as f64),
        }
    }

    /// Interleaves as many runs as there is time for, and records them under the names of their configurations. A
    /// stopped one has no times.
    pub(super) async fn time_in_turn(
        &self,
        names: &[String],
        renderers: &mut [&mut Renderer],
        repeats: usize,
    ) -> Result<Vec<Times>, Error> {
        self.time_rounds(names, renderers, interval::FEWEST.min(repeats), repeats).await
    }

    /// The same with a minimum number of rounds, however long they take.
    pub(super) async fn time_rounds(
        &self,
        names: &[String],
        renderers: &mut [&mut Renderer],
        fewest: usize,
        repeats: usize,
    ) -> Result<Vec<Times>, Error> {
        let all = Some(REPEATS_TAKE * renderers.len() as u32);
        let turns = Turns { all, fewest, seed: u64::from(self.seed()), ..Turns::of(1, repeats) };
        let of = ((1 + repeats) * renderers.len()) as u64;
        let mut rounds = Rounds::new(renderers.len(), turns);
        let mut done = 0;
        while let Some(subject) = rounds.next_subject() {
            self.reporter.part("timing", done, of);
            done += 1;
            rounds.ended(self.run(renderers[subject]).await?);
        }
        let mut all = Vec::new();
        for (name, times) in names.iter().zip(rounds.into_times()) {
            if times.is_given_up {
                all.push(Times { runs: Vec::new(), is_given_up: true });
                continue;
            }
            self.record.add_runs(times.runs.iter().map(|run| {
                self.row(RUN_COLUMNS)
                    .set("section", self.section)
                    .set("configuration", &**name)
                    .set("round", run.round)
                    .set("place", run.place)
                    .set("time_ns", self.ns(run.time))
                    .set("wall_ns", run.time.wall_ns)
                    .set("clock", self.clock())
            }));
            all.push(Times { runs: times.runs.iter().map(|run| self.ns(run.time)).collect(), is_given_up: false });
        }
        Ok(all)
    }
}
