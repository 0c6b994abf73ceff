//! What sections share: a scene on a device, time limits, and interleaved runs.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raystep_kernels::export::csv::Timer;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{GridSize, Options, Progress, RaySource, Renderer};

use crate::meter::{self, Ended, Meter, Time, Turns, in_turn, ratios};
use crate::reporter::Reporter;
use crate::statistics::{low_and_high, median};
use crate::subject::{Size, Subject};
use crate::tidy::Row;
use crate::{Error, Machine};

/// Seed of all random numbers: the same in every run of every version.
pub(super) const SEED: u32 = 2007;

/// Time limit of one run.
const LONGEST_RUN: Duration = Duration::from_secs(20);

/// Time limit for the repeats of one configuration, after the first [`FEWEST`].
const REPEATS_TAKE: Duration = Duration::from_secs(2);
const FEWEST: usize = 3;

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
    pub(super) reporter: &'a dyn Reporter,
}

/// A plan that can be started many times.
pub(super) struct Planned {
    plan: Arc<Plan>,
    data: Arc<SceneData>,
    /// Seconds for planning: mostly for building the structure.
    build_s: f64,
}

/// A renderer that is ready to run, with the times to build it.
pub(super) struct Built {
    pub(super) renderer: Renderer,
    /// Seconds for planning: mostly for building the structure.
    pub(super) build_s: f64,
    /// Seconds for allocating, uploading and compiling.
    pub(super) start_s: f64,
}

/// Times of a configuration.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    /// One per counted run; `None` if the clock had no valid time.
    runs: Vec<Option<f64>>,
    /// Whether a run was stopped: then there are no times, and the streams are incomplete.
    pub(super) is_given_up: bool,
}

impl Times {
    fn known(&self) -> Vec<f64> {
        self.runs.iter().copied().flatten().collect()
    }

    /// The median.
    pub(super) fn median(&self) -> Option<f64> {
        median(&self.known())
    }

    /// Each run divided by the other's run next to it.
    pub(super) fn ratios(&self, to: &Self) -> Vec<f64> {
        ratios(&self.runs, &to.runs)
    }

    /// Fills the time columns.
    pub(super) fn fill(&self, row: Row) -> Row {
        let known = self.known();
        let [low, high] = low_and_high(&known);
        row.set("repeats", known.len()).set("median_ns", self.median()).set("low_ns", low).set("high_ns", high)
    }
}

impl Work<'_> {
    /// The machine that measurements run on.
    pub(super) fn machine(&self) -> &Machine {
        &self.meter.machine
    }

    /// A row with the columns that identify scene and device.
    pub(super) fn row(&self, columns: &'static [&'static str]) -> Row {
        Row::new(columns).set("scene", &*self.subject.scene.name).set("adapter", self.machine().name())
    }

    /// One ray through the centre of each pixel.
    pub(super) fn camera_rays(&self) -> RaySource {
        self.subject.camera_rays(self.size)
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
        self.machine().forget_kernels();
        let begin = Instant::now();
        let (plan, data) = Plan::new(&self.subject.scene, options, &self.machine().limits())?;
        Ok(Planned { plan: Arc::new(plan), data: Arc::new(data), build_s: begin.elapsed().as_secs_f64() })
    }

    /// Allocates, uploads and compiles anew; the driver may cache what it compiles. On a GPU, the caller chooses
    /// whether to time whole runs or passes; on the CPU the total is the sum of the passes.
    pub(super) fn start(&self, planned: &Planned, options: &Options) -> Result<Built, Error> {
        let mut options = options.clone();
        options.timings |= self.machine().gpu().is_none();
        self.machine().forget_kernels();
        let begin = Instant::now();
        let Planned { plan, data, build_s } = planned;
        let starting = Renderer::from_plan(plan.clone(), data.clone(), &options, &self.machine().device);
        let renderer = self.machine().wait(starting)?;
        self.machine().settle();
        Ok(Built { renderer, build_s: *build_s, start_s: begin.elapsed().as_secs_f64() })
    }

    /// Plans and starts.
    pub(super) fn build(&self, options: &Options) -> Result<Built, Error> {
        self.start(&self.plan(options)?, options)
    }

    /// The text of an error in a note.
    pub(super) fn explain(&self, error: &Error) -> String {
        self.reporter.explain(error)
    }

    /// Whether to continue after an error: not if the device itself has failed.
    pub(super) fn can_go_on(&self) -> Result<(), Error> {
        Ok(self.machine().gpu().map_or(Ok(()), |gpu| gpu.health())?)
    }

    /// Runs to the end, or until a limit is reached.
    pub(super) fn run(&self, renderer: &mut Renderer) -> Result<Ended, Error> {
        let watch = |progress: &Progress, spent: Duration| match spent > LONGEST_RUN || progress.passes >= MOST_PASSES {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        Ok(self.meter.run(renderer, watch)?)
    }

    /// The time of a run by the clock that [times passes](Self::clock); `None` if it had no valid time.
    pub(super) fn ns(&self, time: Time) -> Option<f64> {
        match self.machine().timer().times_passes() {
            true => time.device_ns.map(|ns| ns as f64),
            false => Some(time.wall_ns as f64),
        }
    }

    /// Interleaves as many runs as there is time for. A stopped one has no times.
    pub(super) fn time_in_turn(&self, renderers: &mut [&mut Renderer], repeats: usize) -> Result<Vec<Times>, Error> {
        let all = Some(REPEATS_TAKE * renderers.len() as u32);
        let turns = Turns { all, fewest: FEWEST, ..Turns::of(1, repeats) };
        let times = in_turn(renderers, turns, |renderer| self.run(renderer))?;
        let of_one = |times: meter::Times| match times.is_given_up {
            true => Times { runs: Vec::new(), is_given_up: true },
            false => Times { runs: times.runs.iter().map(|run| self.ns(run.time)).collect(), is_given_up: false },
        };
        Ok(times.into_iter().map(of_one).collect())
    }
}
