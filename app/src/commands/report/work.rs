//! What a section works with: a scene on a device, how long runs may take, and runs measured in turn.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raystep_kernels::export::csv::Timer;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{GridSize, Load, Options, RaySource, RenderError, Renderer};
use raystep_lab::Machine;
use raystep_lab::statistics::quantile;

use super::table::Row;
use crate::args::Size;
use crate::commands::input::Input;
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

/// Tests a pass without an accelerator, where passes may have several: a list is as long as the scene.
pub(super) const TESTS_PER_PASS: u32 = 128;

/// Fewer repeats than this have no 5th and 95th percentile.
const FEWEST_FOR_PERCENTILES: usize = 20;

/// A scene to report on.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    pub(super) input: &'a Input,
    pub(super) chosen: &'a Machine,
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
    /// Allocating, uploading, compiling.
    pub(super) start_s: f64,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ended {
    /// All of it, in so many nanoseconds; `None` where the clock had no valid time.
    Done(Option<f64>),
    /// Not at all: it was too slow, or had no end.
    GivenUp,
}

/// Times of a way.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    /// Of each run that counts; `None` where the clock had no valid time.
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
        quantile(&self.known(), 0.5)
    }

    /// By the other's times, each run by the one next to it.
    pub(super) fn ratios(&self, to: &Self) -> Vec<f64> {
        self.runs.iter().zip(&to.runs).filter_map(|(a, b)| Some((*a)? / (*b)?)).collect()
    }

    /// Fills the columns of times.
    pub(super) fn fill(&self, row: Row) -> Row {
        let known = self.known();
        let [low, high] = low_and_high(&known);
        row.set("repeats", known.len()).set("median_ns", self.median()).set("low_ns", low).set("high_ns", high)
    }
}

/// The 5th and the 95th percentile, of few values the smallest and the largest.
pub(super) fn low_and_high(values: &[f64]) -> [Option<f64>; 2] {
    let ends = if values.len() < FEWEST_FOR_PERCENTILES { [0.0, 1.0] } else { [0.05, 0.95] };
    ends.map(|q| quantile(values, q))
}

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
        self.chosen.timer().name()
    }

    /// The same clock, in words.
    pub(super) fn clock_in_words(&self) -> &'static str {
        match self.chosen.timer() {
            Timer::GpuTimestamp { .. } => "the adapter's own timestamps",
            Timer::CpuClock { .. } => "the host's clock around each pass of the CPU twins",
            Timer::Host { .. } => {
                "the host's clock, waiting for the adapter included: it has no timestamps, or none that are true"
            }
        }
    }

    /// Plans and builds.
    pub(super) fn plan(&self, options: &Options) -> Result<Planned, Error> {
        let begin = Instant::now();
        let (plan, data) = Plan::new(&self.input.scene, options, &self.chosen.limits())?;
        Ok(Planned { plan: Arc::new(plan), data: Arc::new(data), build_s: begin.elapsed().as_secs_f64() })
    }

    /// Allocates, uploads, compiles. Whether runs are timed as a whole or by pass is the caller's choice on a GPU; the
    /// twins' total is the sum of their passes.
    pub(super) fn start(&self, planned: &Planned, options: &Options) -> Result<Built, Error> {
        let mut options = options.clone();
        options.timings |= self.chosen.gpu().is_none();
        let begin = Instant::now();
        let Planned { plan, data, build_s } = planned;
        let starting = Renderer::from_plan(plan.clone(), data.clone(), &options, &self.chosen.device);
        let renderer = self.chosen.wait(starting)?;
        self.chosen.settle();
        Ok(Built { renderer, build_s: *build_s, start_s: begin.elapsed().as_secs_f64() })
    }

    /// Both.
    pub(super) fn build(&self, options: &Options) -> Result<Built, Error> {
        self.start(&self.plan(options)?, options)
    }

    /// Whether an error is one of what was asked for, so that the rest can go on: not so where the device has failed.
    pub(super) fn can_go_on(&self) -> Result<(), Error> {
        Ok(self.chosen.gpu().map_or(Ok(()), |gpu| gpu.health())?)
    }

    /// Runs to the end, or until it is given up.
    pub(super) fn run(&self, renderer: &mut Renderer) -> Result<Ended, Error> {
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
        let ended = raystep_lab::block_on(self.chosen.gpu(), renderer.run(watch));
        let wall_ns = begin.elapsed().as_nanos() as f64;
        match ended {
            Ok(()) => {}
            Err(RenderError::Cancelled { .. }) => return Ok(Ended::GivenUp),
            Err(error) => return Err(error.into()),
        }
        Ok(Ended::Done(match self.chosen.timer().times_passes() {
            true => renderer.device_ns().filter(|&ns| ns > 0).map(|ns| ns as f64),
            false => Some(wall_ns),
        }))
    }

    /// Runs all in turn: one run each that warms up, then run 1 of each, run 2 of each, and so on, so that what slows
    /// the machine down for a while slows all of them.
    pub(super) fn time_in_turn(&self, renderers: &mut [&mut Renderer], repeats: usize) -> Result<Vec<Times>, Error> {
        let mut times = vec![Times::default(); renderers.len()];
        let begin = Instant::now();
        for (renderer, times) in renderers.iter_mut().zip(&mut times) {
            times.is_given_up = self.run(renderer)? == Ended::GivenUp;
        }
        let mut spent = Duration::ZERO;
        for done in 0..repeats {
            if done >= FEWEST && spent > REPEATS_TAKE * renderers.len() as u32 {
                break;
            }
            for (renderer, times) in renderers.iter_mut().zip(&mut times).filter(|(_, times)| !times.is_given_up) {
                match self.run(renderer)? {
                    Ended::Done(ns) => times.runs.push(ns),
                    Ended::GivenUp => *times = Times { runs: Vec::new(), is_given_up: true },
                }
            }
            spent = begin.elapsed();
        }
        Ok(times)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_without_a_time_are_left_out_and_shift_no_ratios() {
        let of = |runs: &[Option<f64>]| Times { runs: runs.to_vec(), is_given_up: false };
        let (a, b) = (of(&[Some(2.0), None, Some(8.0)]), of(&[Some(1.0), Some(100.0), Some(2.0)]));
        assert_eq!(a.ratios(&b), [2.0, 4.0]);
        assert_eq!((a.median(), of(&[None]).median()), (Some(5.0), None));
    }

    #[test]
    fn few_values_have_ends_and_many_have_percentiles() {
        let values = |n: u32| (0..n).map(f64::from).collect::<Vec<_>>();
        assert_eq!(low_and_high(&values(19)), [Some(0.0), Some(18.0)]);
        assert_eq!(low_and_high(&values(21)), [Some(1.0), Some(19.0)]);
        assert_eq!(low_and_high(&[]), [None; 2]);
    }
}
