//! When a pass was repeated often enough that its duration can be told from times of a coarse clock.
//!
//! Both ends of a duration t are rounded down to multiples of the step q. The difference D of the two is a multiple of q,
//! and the next smaller or the next larger one to t: t − q < D < t + q. If a run begins anywhere within a step, D is the
//! larger one with the probability f, the part of a step by which t exceeds the smaller one, so that its mean is t and
//! its standard deviation q √(f (1 − f)): q/√6 in the quadratic mean over all f, and at most q/2. The mean of n runs
//! therefore has a standard error of at most q / (2 √n), whatever t is.

use crate::executor::Rounding;

/// The standard error that is aimed at, as a part of the duration: with it, a single run is enough for 5 steps.
const ERROR_WANTED: f64 = 0.1;

/// The largest standard error of a duration that is told, as a part of it.
const MOST_ERROR: f64 = 0.25;

/// Runs after which it is estimated how many more are needed.
const FIRST_RUNS: u32 = 16;

/// Most runs of a pass: with them, 1/8 of a step can be told.
pub(super) const MOST_RUNS: u32 = 256;

/// Time that repeating a pass may take on the device, restoring included, in nanoseconds.
const MOST_NS: f64 = 50e6;

/// The runs of one pass so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Runs {
    step_ns: f64,
    /// Runs with a valid time.
    timed: u32,
    /// The sum of their durations.
    sum_ns: u64,
    /// About the time that they and restoring took.
    taken_ns: u64,
}

impl Runs {
    /// None so far, on a clock with this step.
    pub(super) fn new(step_ns: f64) -> Self {
        Self { step_ns, timed: 0, sum_ns: 0, taken_ns: 0 }
    }

    /// Adds the runs of a submission. Returns whether any of them had a valid time.
    pub(super) fn add(&mut self, times: &[(Option<u64>, Option<u64>)]) -> bool {
        let valid = || times.iter().filter_map(|&(begin, duration)| begin.zip(duration));
        let (first, last) = (valid().next(), valid().next_back());
        let count = valid().count() as u64;
        let span = first.zip(last).map(|((first, _), (begin, duration))| (begin + duration).saturating_sub(first));
        let span = span.unwrap_or(0);
        // Restoring before the first run is not in the span.
        self.taken_ns += match count.checked_sub(1) {
            Some(others) if others > 0 => span * count / others,
            _ => span.max(self.taken_ns / u64::from(self.timed.max(1))),
        };
        self.timed += count as u32;
        self.sum_ns += valid().map(|(_, duration)| duration).sum::<u64>();
        first.is_some()
    }

    fn mean_ns(&self) -> f64 {
        self.sum_ns as f64 / f64::from(self.timed.max(1))
    }

    /// The mean, even if it is too short to tell; `None` without a valid time.
    pub(super) fn estimate_ns(&self) -> Option<u64> {
        (self.timed > 0).then(|| self.mean_ns().round() as u64)
    }

    fn error_ns(&self) -> f64 {
        self.step_ns / (2.0 * f64::from(self.timed.max(1)).sqrt())
    }

    /// The mean, if it can be told.
    pub(super) fn duration_ns(&self) -> Option<u64> {
        self.estimate_ns().filter(|&ns| ns > 0 && self.error_ns() <= MOST_ERROR * self.mean_ns())
    }

    /// How well the duration is known; `None` without a valid time.
    pub(super) fn rounding(&self) -> Option<Rounding> {
        (self.timed > 0).then(|| Rounding {
            runs: self.timed,
            error_ns: self.error_ns().ceil() as u64,
            below_ns: (self.mean_ns() + self.step_ns).ceil() as u64,
        })
    }

    /// How many more runs to submit next; 0 if the duration can be told, or no number of runs would do.
    pub(super) fn more(&self) -> u32 {
        let (mean, error) = (self.mean_ns(), self.error_ns());
        if self.timed == 0 || error <= ERROR_WANTED * mean {
            return 0;
        }
        // Infinite for a mean of 0: as many as there may be.
        let needed = (self.step_ns / (2.0 * ERROR_WANTED * mean)).powi(2).ceil();
        let most = if self.timed < FIRST_RUNS { FIRST_RUNS } else { MOST_RUNS };
        let wanted = needed.min(f64::from(most)) - f64::from(self.timed);
        let a_run = self.taken_ns as f64 / f64::from(self.timed);
        let in_time = if a_run > 0.0 { ((MOST_NS - self.taken_ns as f64) / a_run).floor() } else { wanted };
        wanted.min(in_time).max(0.0) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: u64 = 100_000;

    /// Runs a pass of a duration, and restores for some time after it, until it is told or given up.
    fn measured(duration_ns: u64, restoring_ns: u64) -> (Runs, Vec<u32>) {
        let (mut runs, mut submitted, mut now) = (Runs::new(STEP as f64), Vec::new(), 1_234_567);
        let mut count = 1;
        while count > 0 {
            let times = (0..count).map(|i| {
                // Restoring takes longer at times.
                now += restoring_ns + u64::from(i * 7919 % 13) * 1000;
                let begin = now;
                now += duration_ns;
                let floor = |ns: u64| ns - ns % STEP;
                (Some(floor(begin)), Some(floor(now) - floor(begin)))
            });
            assert!(runs.add(&times.collect::<Vec<_>>()));
            submitted.push(count);
            count = runs.more();
        }
        (runs, submitted)
    }

    #[test]
    fn a_long_pass_runs_once_and_a_short_one_as_often_as_its_error_wants() {
        for (duration_ns, most_runs) in [(5_100_000, 1), (600_000, 1), (300_000, 16), (100_000, 40), (50_000, 130)] {
            let (runs, submitted) = measured(duration_ns, 12_345);
            let told = runs.duration_ns().expect("it can be told") as f64;
            let rounding = runs.rounding().expect("it was timed");
            let n = submitted.iter().sum::<u32>();
            assert_eq!(rounding.runs, n);
            assert!(n <= most_runs && (n > 1) == (most_runs > 1), "{duration_ns} ns: {submitted:?}");
            let error = rounding.error_ns as f64;
            assert_eq!(error, (STEP as f64 / (2.0 * f64::from(n).sqrt())).ceil());
            assert!(error <= 0.1 * told + 1.0, "{duration_ns} ns: {error} of {told}");
            assert!((told - duration_ns as f64).abs() <= 3.0 * error, "{duration_ns} ns: {told} ± {error}");
            assert!(rounding.below_ns > duration_ns);
        }
    }

    #[test]
    fn what_takes_an_eighth_of_a_step_is_told_and_what_takes_much_less_is_too_short() {
        let (runs, submitted) = measured(16_000, 12_345);
        assert_eq!(submitted, [1, 15, 240]);
        let told = runs.duration_ns().expect("it can be told");
        assert!(told.abs_diff(16_000) < 3 * 3125, "{told}");
        for duration_ns in [0, 3000] {
            let (runs, submitted) = measured(duration_ns, 12_345);
            assert_eq!(submitted, [1, 15, 240]);
            assert_eq!(runs.duration_ns(), None);
            assert!(runs.estimate_ns().is_some_and(|ns| ns < 3 * 3125));
            assert!(runs.rounding().is_some_and(|r| r.runs == 256 && (STEP..2 * STEP).contains(&r.below_ns)));
        }
    }

    #[test]
    fn repeating_ends_when_it_has_taken_long_and_without_valid_times() {
        let (runs, submitted) = measured(20_000, 2_000_000);
        assert!(submitted.iter().sum::<u32>() <= 27, "{submitted:?}");
        assert!(runs.taken_ns <= 60_000_000, "{runs:?}");
        let mut runs = Runs::new(STEP as f64);
        assert!(!runs.add(&[(None, None), (Some(5), None)]));
        assert_eq!((runs.more(), runs.duration_ns(), runs.estimate_ns(), runs.rounding()), (0, None, None, None));
    }
}
