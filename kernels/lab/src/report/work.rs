//! What a section works with: a scene on a device, how long runs may take, and runs measured in turn.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raystep_kernels::export::csv::Timer;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{GridSize, Options, Progress, RaySource, Renderer};

use super::table::Row;
use crate::meter::{self, Ended, Meter, Time, Turns, in_turn, ratios};
use crate::reporter::Reporter;
use crate::statistics::{low_and_high, median};
use crate::subject::{Size, Subject};
use crate::{Error, Machine};

/// What all random numbers begin with: the same in every run of every version.
pub(super) const SEED: u32 = 2007;

/// What one run may take before it is given up.
const LONGEST_RUN: Duration = Duration::from_secs(20);

/// What the repeats of one way may take together, where that leaves [`FEWEST`].
const REPEATS_TAKE: Duration = Duration::from_secs(2);
const FEWEST: usize = 3;

/// Passes after which a run is given up: by the paper's rules a walk may have no end.
const MOST_PASSES: usize = 100_000;

/// Tests a pass without an accelerator, where passes may have several: a list is as long as the scene.
pub(super) const TESTS_PER_PASS: u32 = 128;

/// A scene to report on.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    pub(super) subject: &'a Subject,
    pub(super) meter: &'a Meter,
    pub(super) size: Size,
    /// For what is not about the grid's resolution.
    pub(super) grid: GridSize,
    pub(super) is_quick: bool,
    pub(super) reporter: &'a dyn Reporter,
}

/// Something that is planned, for as many runs as are wanted.
pub(super) struct Planned {
    plan: Arc<Plan>,
    data: Arc<SceneData>,
    /// Planning: the structure above all.
    build_s: f64,
}

/// Something that is ready to run, and what that took.
pub(super) struct Built {
    pub(super) renderer: Renderer,
    /// Planning: the structure above all.
    pub(super) build_s: f64,
    /// Allocating, uploading, compiling.
    pub(super) start_s: f64,
}

/// Times of a way.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    /// Of each run that counts; `None` if the clock had no valid time.
    runs: Vec<Option<f64>>,
    /// A run was given up: there are no times, and its streams are as far as it came.
    pub(super) is_given_up: bool,
}

impl Times {
    fn known(&self) -> Vec<f64> {
        self.runs.iter().copied().flatten().collect()
    }

    /// The middle one.
    pub(super) fn median(&self) -> Option<f64> {
        median(&self.known())
    }

    /// By the other's times, each run by the one next to it.
    pub(super) fn ratios(&self, to: &Self) -> Vec<f64> {
        ratios(&self.runs, &to.runs)
    }

    /// Fills the columns of times.
    pub(super) fn fill(&self, row: Row) -> Row {
        let known = self.known();
        let [low, high] = low_and_high(&known);
        row.set("repeats", known.len()).set("median_ns", self.median()).set("low_ns", low).set("high_ns", high)
    }
}

impl Work<'_> {
    /// What it is measured on.
    pub(super) fn machine(&self) -> &Machine {
        &self.meter.machine
    }

    /// A row that says of what and where.
    pub(super) fn row(&self, columns: &'static [&'static str]) -> Row {
        Row::new(columns).set("scene", &*self.subject.scene.name).set("adapter", self.machine().name())
    }

    /// One ray through the middle of each pixel.
    pub(super) fn camera_rays(&self) -> RaySource {
        self.subject.camera_rays(self.size)
    }

    /// The less of it the quicker.
    pub(super) fn either<T>(&self, quick: T, normal: T) -> T {
        if self.is_quick { quick } else { normal }
    }

    /// A stage of the section begins.
    pub(super) fn stage(&self, what: &str) {
        self.reporter.stage(&format!("{}: {what}", self.subject.scene.name));
    }

    /// The clock that times are of.
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

    /// Plans and builds, with kernels composed anew.
    pub(super) fn plan(&self, options: &Options) -> Result<Planned, Error> {
        self.machine().forget_kernels();
        let begin = Instant::now();
        let (plan, data) = Plan::new(&self.subject.scene, options, &self.machine().limits())?;
        Ok(Planned { plan: Arc::new(plan), data: Arc::new(data), build_s: begin.elapsed().as_secs_f64() })
    }

    /// Allocates, uploads, compiles anew; what its driver caches, the driver keeps. Whether runs are timed as a whole or by pass is the caller's choice on a GPU; the
    /// twins' total is the sum of their passes.
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

    /// Both.
    pub(super) fn build(&self, options: &Options) -> Result<Built, Error> {
        self.start(&self.plan(options)?, options)
    }

    /// An error within a note.
    pub(super) fn explain(&self, error: &Error) -> String {
        self.reporter.explain(error)
    }

    /// Whether an error is one of what was asked for, so that the rest can go on: not so where the device has failed.
    pub(super) fn can_go_on(&self) -> Result<(), Error> {
        Ok(self.machine().gpu().map_or(Ok(()), |gpu| gpu.health())?)
    }

    /// Runs to the end, or until it is given up.
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

    /// Runs all in turn, as often as there is time for. One that was given up has no times.
    pub(super) fn time_in_turn(&self, renderers: &mut [&mut Renderer], repeats: usize) -> Result<Vec<Times>, Error> {
        let all = Some(REPEATS_TAKE * renderers.len() as u32);
        let turns = Turns { all, fewest: FEWEST, ..Turns::of(1, repeats) };
        let times = in_turn(renderers, turns, |renderer| self.run(renderer))?;
        let of_one = |times: meter::Times| match times.is_given_up {
            true => Times { runs: Vec::new(), is_given_up: true },
            false => Times { runs: times.runs.iter().map(|&time| self.ns(time)).collect(), is_given_up: false },
        };
        Ok(times.into_iter().map(of_one).collect())
    }
}
