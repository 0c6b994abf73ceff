//! Times runs. Runs to be compared are interleaved (run 1 of each, run 2 of each, and so on), so that a temporary
//! slowdown of the machine affects all of them; the first runs warm up and do not count. The order within a round is
//! random, and reversed in the next round, so that no run always follows the same other one.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use raystep_kernels::numbers::parallel::map_ranges;
use raystep_kernels::{Device, Load, Progress, RenderError, Renderer};

use crate::machine::Machine;
use crate::rays::Random;
use crate::statistics::interval::{self, Interval};
use crate::statistics::median;

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
    /// By the host's clock, including waiting for the device.
    pub wall_ns: u64,
    /// By the device's clock; `None` if it has none, or the time is not valid.
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

/// How many runs to make of each subject.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Turns {
    /// Uncounted runs of each.
    pub warmups: usize,
    /// Maximum number of counted runs of each.
    pub repeats: usize,
    /// Minimum number of counted runs, however long they take.
    pub fewest: usize,
    /// Time limit for all runs together; `None` for no limit.
    pub all: Option<Duration>,
    /// Time limit for the counted runs of each.
    pub each: Option<Duration>,
    /// Seed of the orders within rounds.
    pub seed: u64,
}

impl Turns {
    /// A fixed number of runs of each, without time limits.
    #[must_use]
    pub fn of(warmups: usize, repeats: usize) -> Self {
        Self { warmups, repeats, fewest: repeats, all: None, each: None, seed: 0 }
    }
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
    pub fn keep_clocks(&self) {
        self.load.iter().for_each(Load::submit);
        self.machine.settle();
    }

    /// The time of a fixed piece of work by the host's clock, in nanoseconds: it tells a slower machine from slower
    /// kernels. On a GPU it is the load that keeps its clocks up, otherwise integer arithmetic on all cores.
    #[must_use]
    pub fn fixed_work_ns(&self) -> u64 {
        /// About a millisecond on two cores.
        const TASKS: usize = 64;
        const STEPS: u64 = 1 << 15;
        self.machine.settle();
        let start = Instant::now();
        match &self.load {
            Some(load) if load.has_effect() => {
                load.submit();
                self.machine.settle();
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

    /// Keeps the device busy for this long, until its clocks are up; what runs next should keep them there.
    pub fn raise_clocks(&self, time: Duration) {
        let start = Instant::now();
        while start.elapsed() < time {
            self.keep_clocks();
        }
    }

    /// One run from its start, until it ends or `watch` stops it; `watch` also gets the time so far.
    ///
    /// # Errors
    /// If the device fails.
    pub fn run(
        &self,
        renderer: &mut Renderer,
        mut watch: impl FnMut(&Progress, Duration) -> ControlFlow<()>,
    ) -> Result<Ended, RenderError> {
        renderer.restart();
        self.keep_clocks();
        let start = Instant::now();
        let ended = self.machine.wait(renderer.run(|progress| watch(progress, start.elapsed())));
        let wall_ns = start.elapsed().as_nanos() as u64;
        match ended {
            Ok(()) => Ok(Ended::Done(Time { wall_ns, device_ns: renderer.device_ns().filter(|&ns| ns > 0) })),
            Err(RenderError::Cancelled { .. }) => Ok(Ended::GivenUp),
            Err(error) => Err(error),
        }
    }
}

/// Runs all of `subjects`, interleaved. One that was stopped is not run again.
///
/// # Errors
/// The first error of `run`.
pub fn in_turn<T, E>(
    subjects: &mut [T],
    turns: Turns,
    mut run: impl FnMut(&mut T) -> Result<Ended, E>,
) -> Result<Vec<Times>, E> {
    let mut times = vec![Times::default(); subjects.len()];
    let mut spent = vec![Duration::ZERO; subjects.len()];
    let begin = Instant::now();
    let mut random = Random::new(turns.seed);
    let mut order: Vec<usize> = (0..subjects.len()).collect();
    for turn in 0..turns.warmups + turns.repeats {
        let counting = turn.checked_sub(turns.warmups);
        match counting {
            Some(round) if round % 2 == 1 => order.reverse(),
            _ => random.shuffle(&mut order),
        }
        let is_extra = counting.is_some_and(|done| done >= turns.fewest);
        if is_extra && turns.all.is_some_and(|all| begin.elapsed() > all) {
            break;
        }
        for (place, &i) in order.iter().enumerate() {
            let (subject, times, spent) = (&mut subjects[i], &mut times[i], &mut spent[i]);
            if times.is_given_up || is_extra && turns.each.is_some_and(|each| *spent > each) {
                continue;
            }
            let start = Instant::now();
            match (run(subject)?, counting) {
                (Ended::GivenUp, _) => times.is_given_up = true,
                (Ended::Done(time), Some(round)) => times.runs.push(Run { round, place, time }),
                (Ended::Done(_), None) => {}
            }
            if counting.is_some() {
                *spent += start.elapsed();
            }
        }
    }
    Ok(times)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn done(ns: u64) -> Result<Ended, ()> {
        Ok(Ended::Done(Time { wall_ns: ns, device_ns: Some(ns) }))
    }

    #[test]
    fn all_run_in_turn_and_warm_ups_do_not_count() {
        let mut order = Vec::new();
        let times = in_turn(&mut ['a', 'b'], Turns::of(1, 2), |subject| {
            order.push(*subject);
            done(order.len() as u64)
        });
        let times = times.expect("no error");
        assert_eq!(times.iter().map(|times| times.runs.len()).collect::<Vec<_>>(), [2, 2]);
        assert!(order.chunks(2).all(|round| round.contains(&'a') && round.contains(&'b')), "{order:?}");
        assert!(times.iter().flat_map(Times::wall_ns).all(|ns| ns > 2.0), "{times:?}");
        let failed = in_turn(&mut [1, 2], Turns::of(0, 1), |n| if *n == 2 { Err(*n) } else { Ok(Ended::GivenUp) });
        assert_eq!(failed, Err(2));
    }

    #[test]
    fn the_order_is_random_and_reversed_in_every_other_round() {
        let orders = |seed| {
            let mut order = Vec::new();
            let run = |subject: &mut u32| {
                order.push(*subject);
                done(1)
            };
            let times = in_turn(&mut [0, 1, 2, 3], Turns { seed, ..Turns::of(0, 8) }, run).expect("no error");
            for (subject, times) in times.iter().enumerate() {
                for Run { round, place, .. } in &times.runs {
                    assert_eq!(order[4 * round + place], subject as u32);
                }
            }
            order
        };
        let first = orders(1);
        for pair in first.chunks(8) {
            assert!(pair[..4].iter().eq(pair[4..].iter().rev()), "{pair:?}");
        }
        assert_ne!(first[..8], first[8..16]);
        assert_eq!(first, orders(1));
        assert_ne!(first, orders(2));
    }

    #[test]
    fn what_is_given_up_runs_no_more_and_holds_up_nobody() {
        let mut runs = [0; 2];
        let times = in_turn(&mut [0, 1], Turns::of(1, 3), |&mut i| {
            runs[i] += 1;
            if i == 0 && runs[0] == 2 { Ok(Ended::GivenUp) } else { done(1) }
        });
        let times = times.expect("no error");
        assert_eq!((runs, times[0].runs.len(), times[1].runs.len()), ([2, 4], 0, 3));
        assert!(times[0].is_given_up && !times[1].is_given_up);
    }

    #[test]
    fn the_fewest_are_made_whatever_they_take() {
        let none = Some(Duration::ZERO);
        let count = |turns: Turns| {
            let mut runs = 0;
            let times = in_turn(&mut [()], turns, |()| {
                runs += 1;
                std::thread::sleep(Duration::from_millis(1));
                done(1)
            });
            assert_eq!(times.map(|times| times[0].runs.len()), Ok(runs - turns.warmups));
            runs
        };
        let turns = Turns { fewest: 2, ..Turns::of(1, 9) };
        assert_eq!(count(Turns { all: none, ..turns }), 3);
        assert_eq!(count(Turns { each: none, ..turns }), 3);
        assert_eq!(count(turns), 10);
    }

    #[test]
    fn runs_without_a_time_are_left_out_and_shift_no_ratios() {
        let (a, b) = ([Some(2.0), None, Some(8.0)], [Some(1.0), Some(100.0), Some(2.0)]);
        assert_eq!(ratios(&a, &b), [2.0, 4.0]);
        assert_eq!(Valid::of(&[Some(2), None, Some(8)]), Valid { ns: vec![2.0, 8.0], invalid: 1 });
        assert_eq!((Valid::of(&[Some(2), None, Some(8)]).median(), Valid::of(&[None]).median()), (Some(5.0), None));
    }
}
