//! Times runs. Runs to be compared are interleaved (run 1 of each, run 2 of each, and so on), so that a temporary
//! slowdown of the machine affects all of them; the first runs warm up and do not count. The order within a round is
//! random, and reversed in the next round, so that no run always follows the same other one.

mod turns;

use std::ops::ControlFlow;
use std::time::Duration;

use raystep_kernels::numbers::parallel::map_ranges;
use raystep_kernels::{Device, Load, Progress, RenderError, Renderer};
use web_time::Instant;

use crate::machine::Machine;
use crate::statistics::interval::{self, Interval};
use crate::statistics::median;
use crate::tidy::Row;
pub use turns::{Rounds, Turns, in_turn};

/// A machine that can time runs.
pub struct Meter {
    /// The machine.
    pub machine: Machine,
    /// Keeps a GPU busy between runs, so that its clocks stay up.
    load: Option<Load>,
}

/// The time of one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Time {
    /// By the host's clock, from begin to end: it includes waiting for the device, and in a thread with other tasks what
    /// these did meanwhile, such as drawing a browser's window.
    pub wall_ns: u64,
    /// By the device's clock, the time of its passes only: on the CPU, what other tasks did between passes is not part
    /// of it. `None` if the device has no clock, or the time is not valid.
    pub device_ns: Option<u64>,
}

/// A counted run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The round, from 0: runs of the same round are compared.
    pub round: usize,
    /// Its position in the round, from 0.
    pub place: usize,
    /// Its time.
    pub time: Time,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It completed.
    Done(Time),
    /// It was stopped: too slow, or endless.
    GivenUp,
}

/// The times of one subject's runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Times {
    /// The counted runs, one a round.
    pub runs: Vec<Run>,
    /// Whether a run was stopped; no more were made after it.
    pub is_given_up: bool,
}

impl Times {
    /// Nanoseconds of each run by the device's clock; `None` for a run without a valid time.
    #[must_use]
    pub fn device_ns(&self) -> Vec<Option<u64>> {
        self.runs.iter().map(|run| run.time.device_ns).collect()
    }

    /// Nanoseconds of each run by the host's clock.
    #[must_use]
    pub fn wall_ns(&self) -> Vec<f64> {
        self.runs.iter().map(|run| run.time.wall_ns as f64).collect()
    }
}

/// Valid times, and the number of runs without one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Valid {
    /// In nanoseconds.
    pub ns: Vec<f64>,
    /// Number of runs without a valid time.
    pub invalid: usize,
}

impl Valid {
    /// Separates runs with and without a time.
    #[must_use]
    pub fn of(runs: &[Option<u64>]) -> Self {
        let ns: Vec<f64> = runs.iter().flatten().map(|&ns| ns as f64).collect();
        Self { invalid: runs.len() - ns.len(), ns }
    }

    /// The median.
    #[must_use]
    pub fn median(&self) -> Option<f64> {
        median(&self.ns)
    }

    /// The 95% confidence interval of the median; `None` if there are too few runs.
    #[must_use]
    pub fn interval(&self) -> Option<Interval> {
        interval::of_median(&self.ns, 0)
    }
}

/// Each run's time divided by the time of the other's run in the same round.
#[must_use]
pub fn ratios(of: &[Option<f64>], to: &[Option<f64>]) -> Vec<f64> {
    of.iter().zip(to).filter_map(|(a, b)| Some((*a)? / (*b)?)).collect()
}

impl Meter {
    /// Fills the columns of a counted run.
    pub(crate) fn fill_run(&self, run: &Run, row: Row) -> Row {
        row.set("round", run.round)
            .set("place", run.place)
            .set("time_ns", self.ns(run.time).map(|ns| ns as u64))
            .set("wall_ns", run.time.wall_ns)
            .set("clock", self.machine.timer().name())
    }

    /// Nanoseconds of a run by the clock that times passes, or by the host's without one; `None` without a valid time.
    #[must_use]
    pub fn ns(&self, time: Time) -> Option<f64> {
        match self.machine.timer().times_passes() {
            true => time.device_ns.map(|ns| ns as f64),
            false => Some(time.wall_ns as f64),
        }
    }

    /// A meter for a machine.
    #[must_use]
    pub fn new(machine: Machine) -> Self {
        let load = match &machine.device {
            Device::Gpu(gpu) => Some(Load::new(gpu.clone())),
            Device::Cpu(_) | Device::CpuF64(_) => None,
        };
        Self { machine, load }
    }

    /// Gives the device a little work, and waits for it and everything submitted before: none of it affects the next
    /// time or its wall clock.
    pub async fn keep_clocks(&self) {
        self.load.iter().for_each(Load::submit);
        self.machine.settle().await;
    }

    /// The time of a fixed piece of work by the host's clock, in nanoseconds: it tells a slower machine from slower
    /// kernels. On a GPU it is the load that keeps its clocks up, otherwise integer arithmetic on all cores. Blocks this
    /// thread.
    #[must_use]
    pub fn fixed_work_ns(&self) -> u64 {
        /// About a millisecond on two cores.
        const TASKS: usize = 64;
        const STEPS: u64 = 1 << 15;
        self.machine.wait(self.machine.settle());
        let start = Instant::now();
        match &self.load {
            Some(load) if load.has_effect() => {
                load.submit();
                self.machine.wait(self.machine.settle());
            }
            _ => {
                // Knuth's MMIX generator.
                let step =
                    |value: u64, _| std::hint::black_box(value.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
                map_ranges(TASKS, 1, |range| (0..STEPS).fold(range.start as u64, step));
            }
        }
        start.elapsed().as_nanos() as u64
    }

    /// Keeps the device busy for this long, until its clocks are up; what runs next should keep them there. Blocks this
    /// thread.
    pub fn raise_clocks(&self, time: Duration) {
        let start = Instant::now();
        while start.elapsed() < time {
            self.machine.wait(self.keep_clocks());
        }
    }

    /// One run from its start, stopped if it takes longer.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn run_within(&self, longest: Duration, renderer: &mut Renderer) -> Result<Ended, RenderError> {
        self.run(renderer, |_, spent| if spent > longest { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
            .await
    }

    /// One run from its start, until it ends or `watch` stops it; `watch` also gets the time so far.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn run(
        &self,
        renderer: &mut Renderer,
        mut watch: impl FnMut(&Progress, Duration) -> ControlFlow<()>,
    ) -> Result<Ended, RenderError> {
        renderer.restart();
        self.keep_clocks().await;
        let start = Instant::now();
        let ended = renderer.run(|progress| watch(progress, start.elapsed())).await;
        let wall_ns = start.elapsed().as_nanos() as u64;
        match ended {
            Ok(()) => Ok(Ended::Done(Time { wall_ns, device_ns: renderer.device_ns().filter(|&ns| ns > 0) })),
            Err(RenderError::Cancelled { .. }) => Ok(Ended::GivenUp),
            Err(error) => Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_without_a_time_are_left_out_and_shift_no_ratios() {
        let (a, b) = ([Some(2.0), None, Some(8.0)], [Some(1.0), Some(100.0), Some(2.0)]);
        assert_eq!(ratios(&a, &b), [2.0, 4.0]);
        assert_eq!(Valid::of(&[Some(2), None, Some(8)]), Valid { ns: vec![2.0, 8.0], invalid: 1 });
        assert_eq!((Valid::of(&[Some(2), None, Some(8)]).median(), Valid::of(&[None]).median()), (Some(5.0), None));
    }
}
