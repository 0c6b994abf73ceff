//! The gate on simulated times whose truth is known.

use super::paired::{Looks, SITTINGS, judge, order};
use super::{Times, Verdict, needed_repeats};
use crate::rays::Random;

const TRIALS: u64 = 2_000;
const ROWS: usize = 6;

/// A machine that other programs use, too.
struct Busy {
    random: Random,
    /// Logarithm of its speed; it wanders slowly and returns.
    drift: f64,
    /// Whether another program takes half of it: for 30 runs on average, every 60.
    is_taken: bool,
}

impl Busy {
    fn new(seed: u64) -> Self {
        Self { random: Random::new(seed), drift: 0.0, is_taken: false }
    }

    /// Normal, nearly.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.random.unit()).sum::<f64>() - 6.0
    }

    /// How much longer the next run takes than on an idle machine. Runs that follow each other are slow together; one in
    /// twenty has an interruption of its own, with a heavy tail (Pareto, index 1.5).
    fn slows(&mut self) -> f64 {
        self.drift = 0.98 * self.drift + 0.02 * self.normal();
        let flips = if self.is_taken { 1.0 / 30.0 } else { 1.0 / 60.0 };
        self.is_taken ^= self.random.unit() < flips;
        let tail = if self.random.unit() < 0.05 { 0.1 * (1.0 - self.random.unit()).powf(-1.0 / 1.5) } else { 0.0 };
        let own = 0.05 * self.normal();
        (self.drift + own).exp() * if self.is_taken { 1.7 } else { 1.0 } * (1.0 + tail)
    }
}

/// The gate's whole course: sittings, rounds, looks. `process` is the spread of the speeds of processes. Returns the
/// verdict and the last look.
fn run(seed: u64, most: usize, truth: [f64; ROWS], at_most: f64, process: f64) -> (Verdict, Vec<Times>) {
    let mut machine = Busy::new(seed);
    let mut logs = vec![Vec::new(); ROWS];
    let looks = Looks { most };
    let mut last = Vec::new();
    for sitting in 0..SITTINGS {
        let mut speed = || [0; ROWS].map(|_| (process * machine.normal()).exp());
        let speeds = [speed(), speed()];
        for _ in looks.rounds(sitting) {
            for (row, other_first) in order(ROWS, &mut machine.random) {
                let mut times = [machine.slows(), machine.slows()];
                times[usize::from(other_first)] *= truth[row] * speeds[0][row];
                times[usize::from(!other_first)] *= speeds[1][row];
                let [now, then] = if other_first { [times[1], times[0]] } else { times };
                logs[row].push((now / then).ln());
            }
        }
        if looks.is_look(sitting) {
            last = judge(&logs, at_most, Looks::level());
            if last.iter().any(|row| row.verdict == Verdict::Fail) {
                return (Verdict::Fail, last);
            }
            if last.iter().all(|row| row.verdict == Verdict::Pass) {
                return (Verdict::Pass, last);
            }
        }
    }
    (Verdict::Undecided, last)
}

fn count(wanted: Verdict, most: usize, truth: [f64; ROWS], at_most: f64, process: f64) -> u64 {
    (0..TRIALS).filter(|&trial| run(trial, most, truth, at_most, process).0 == wanted).count() as u64
}

#[test]
fn equal_builds_fail_in_less_than_5_percent_of_runs() {
    const EQUAL: [f64; ROWS] = [1.0; ROWS];
    // At a limit of 1, the level is used up; above it, equal builds fail yet less. Processes that differ by 2% are no
    // reason to fail at 1.05.
    for (most, at_most, process) in [(40, 1.0, 0.0), (160, 1.0, 0.0), (40, 1.05, 0.02), (160, 1.05, 0.02)] {
        let failed = count(Verdict::Fail, most, EQUAL, at_most, process);
        println!("{most} repeats, limit {at_most}: {failed} of {TRIALS} equal builds fail");
        assert!(failed <= TRIALS / 20, "{most} repeats, limit {at_most}: {failed} of {TRIALS}");
    }
    // Nor does a build at the limit pass more often than that.
    let mut at_limit = EQUAL;
    at_limit[2] = 1.05;
    let passed = count(Verdict::Pass, 160, at_limit, 1.05, 0.0);
    println!("{passed} of {TRIALS} builds at the limit pass");
    assert!(passed <= TRIALS / 20, "{passed} of {TRIALS} pass");
}

#[test]
fn a_build_that_takes_a_fifth_longer_fails_within_the_repeats_that_the_gate_asks_for() {
    let mut slow = [1.0; ROWS];
    slow[4] = 1.2;
    for first in [12, 40] {
        let mut asked = Vec::new();
        let failed = (0..TRIALS).filter(|&trial| {
            let (verdict, rows) = run(trial, first, slow, 1.05, 0.0);
            if verdict != Verdict::Undecided {
                return verdict == Verdict::Fail;
            }
            let Some(repeats) = needed_repeats(1.05, rows.iter()) else { return false };
            asked.push(repeats);
            run(trial + TRIALS, repeats.min(100_000) as usize, slow, 1.05, 0.0).0 == Verdict::Fail
        });
        let failed = failed.count() as u64;
        asked.sort_unstable();
        let middle = asked.get(asked.len() / 2).copied().unwrap_or(0);
        println!(
            "{first} repeats first: {failed} of {TRIALS} fail; {} asked for more, for {middle} in the middle",
            asked.len()
        );
        assert!(failed * 100 >= TRIALS * 95, "{first} repeats first: {failed} of {TRIALS}");
    }
}

#[test]
fn equal_builds_pass_in_the_end() {
    let passed = count(Verdict::Pass, 400, [1.0; ROWS], 1.1, 0.0);
    println!("{passed} of {TRIALS} equal builds pass");
    assert!(passed * 100 >= TRIALS * 95, "{passed} of {TRIALS}");
}
