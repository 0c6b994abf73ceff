//! What a section works with: a scene on a device, how long runs may take, and runs measured in turn.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raystep_kernels::export::csv::Timer;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{GridSize, Load, Options, RaySource, RenderError, Renderer};

use super::table::Row;
use crate::args::Size;
use crate::commands::input::Input;
use crate::device::Chosen;
use crate::error::Error;
use crate::terminal::Progress;

/// What all random numbers begin with: the same in every run of every version.
pub(super) const SEED: u32 = 2007;

/// What one run may take before it is given up.
const LONGEST_RUN: Duration = Duration::from_secs(20);

/// What the repeats of one way may take together, where that leaves [`FEWEST`].
const REPEATS_TAKE: Duration = Duration::from_secs(2);
const FEWEST: usize = 3;

/// Passes after which a run is given up: by the paper's rules a walk may have no end.
const MOST_PASSES: usize = 100_000;

/// A scene to report on.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    pub(super) input: &'a Input,
    pub(super) chosen: &'a Chosen,
    pub(super) size: Size,
    /// For what is not about the grid's resolution.
    pub(super) grid: GridSize,
    pub(super) is_quick: bool,
    pub(super) progress: &'a Progress,
    /// What a GPU does between runs, which keeps its clocks up.
    pub(super) load: Option<&'a Load>,
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
    /// Compiling, allocating, uploading.
    pub(super) compile_s: f64,
}

/// Times of a way, of each run that counts.
pub(super) type Times = Vec<f64>;

impl Work<'_> {
    /// A row that says of what and where.
    pub(super) fn row(&self, columns: &'static [&'static str]) -> Row {
        Row::new(columns).set("scene", &*self.input.scene.name).set("adapter", self.chosen.name())
    }

    /// One ray through the middle of each pixel.
    pub(super) fn camera_rays(&self) -> RaySource {
        let Size { width, height } = self.size;
        RaySource::Camera { camera: self.input.camera.clone(), width, height }
    }

    /// The less of it the quicker.
    pub(super) fn either<T>(&self, quick: T, normal: T) -> T {
        if self.is_quick { quick } else { normal }
    }

    /// A stage of the section begins.
    pub(super) fn stage(&self, what: &str) {
        self.progress.stage(&format!("{}: {what}", self.input.scene.name));
    }

    /// The clock that times are of.
    pub(super) fn clock(&self) -> &'static str {
        self.chosen.timer().map_or("wall", Timer::name)
    }

    /// The same clock, in words.
    pub(super) fn clock_in_words(&self) -> &'static str {
        match self.chosen.timer() {
            Some(Timer::GpuTimestamp { .. }) => "the adapter's own timestamps",
            Some(Timer::CpuClock { .. }) => "the wall clock around each pass of the CPU twins",
            None => "the wall clock, waiting for the adapter included: it has no timestamps",
        }
    }

    /// Plans and builds.
    pub(super) fn plan(&self, options: &Options) -> Result<Planned, Error> {
        let begin = Instant::now();
        let (plan, data) = Plan::new(&self.input.scene, options, &self.chosen.limits())?;
        Ok(Planned { plan: Arc::new(plan), data: Arc::new(data), build_s: begin.elapsed().as_secs_f64() })
    }

    /// Compiles, allocates, uploads. Whether runs are timed as a whole or by pass is the caller's choice on a GPU; the
    /// twins' total is the sum of their passes.
    pub(super) fn start(&self, planned: &Planned, options: &Options) -> Result<Built, Error> {
        let mut options = options.clone();
        options.timings |= self.chosen.gpu().is_none();
        let begin = Instant::now();
        let Planned { plan, data, build_s } = planned;
        let starting = Renderer::from_plan(plan.clone(), data.clone(), &options, &self.chosen.device);
        let renderer = self.chosen.wait(starting)?;
        self.chosen.settle();
        Ok(Built { renderer, build_s: *build_s, compile_s: begin.elapsed().as_secs_f64() })
    }

    /// Both.
    pub(super) fn build(&self, options: &Options) -> Result<Built, Error> {
        self.start(&self.plan(options)?, options)
    }

    /// Whether an error is one of what was asked for, so that the rest can go on: not so where the device has failed.
    pub(super) fn can_go_on(&self) -> Result<(), Error> {
        Ok(self.chosen.gpu().map_or(Ok(()), |gpu| gpu.health())?)
    }

    /// Runs to the end: its time in nanoseconds. `None` where it was given up.
    pub(super) fn run(&self, renderer: &mut Renderer) -> Result<Option<f64>, Error> {
        renderer.restart();
        // Until just before the run, and so not in its wall clock.
        self.load.iter().for_each(|load| load.submit());
        self.chosen.settle();
        let begin = Instant::now();
        let watch = |progress: &raystep_kernels::Progress| match begin.elapsed() > LONGEST_RUN
            || progress.passes >= MOST_PASSES
        {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let ended = crate::device::block_on(self.chosen.gpu(), renderer.run(watch));
        let wall_ns = begin.elapsed().as_nanos() as f64;
        match ended {
            Ok(()) => {}
            Err(RenderError::Cancelled { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        }
        Ok(match self.chosen.timer() {
            Some(_) => renderer.device_ns().filter(|&ns| ns > 0).map(|ns| ns as f64),
            None => Some(wall_ns),
        })
    }

    /// Runs all in turn: one run each that warms up, then run 1 of each, run 2 of each, and so on, so that what slows
    /// the machine down for a while slows all of them. No times of what was given up.
    pub(super) fn time_in_turn(&self, renderers: &mut [&mut Renderer], repeats: usize) -> Result<Vec<Times>, Error> {
        let mut times: Vec<Times> = vec![Vec::new(); renderers.len()];
        let mut is_out = vec![false; renderers.len()];
        let begin = Instant::now();
        for (renderer, is_out) in renderers.iter_mut().zip(&mut is_out) {
            *is_out = self.run(renderer)?.is_none();
        }
        let mut spent = Duration::ZERO;
        for done in 0..repeats {
            if done >= FEWEST && spent > REPEATS_TAKE * renderers.len() as u32 {
                break;
            }
            for ((renderer, times), is_out) in renderers.iter_mut().zip(&mut times).zip(&is_out) {
                if !is_out && let Some(ns) = self.run(renderer)? {
                    times.push(ns);
                }
            }
            spent = begin.elapsed();
        }
        Ok(times)
    }
}
