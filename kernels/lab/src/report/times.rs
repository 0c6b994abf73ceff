//! Interleaved runs of a section's configurations, within its time.
//!
//! Each runs once at first. What is then so slow that the fewest rounds of all would exceed the time that is left is not
//! run again: it keeps its one time, without an interval, and that is said. Where the fastest is looked for, what is
//! clearly slower leaves once its time has an interval, unless there is time for all.

mod race;

use std::time::Duration;

pub(super) use race::{Amount, Race};
use race::{clearly_slower, fitting, will_fit};
use raystep_kernels::Renderer;
use web_time::Instant;

use super::record::RUN_COLUMNS;
use super::work::Work;
use crate::Error;
use crate::meter::{self, Ended, Rounds, Run, Time, Turns};
use crate::statistics::interval::{self, Interval};
use crate::statistics::median;
use crate::tidy::{Row, fill};

/// Time limit for the repeats of one configuration, after the first [`interval::FEWEST`].
const REPEATS_TAKE: Duration = Duration::from_secs(1);

/// Share of a section's time after which no more is built, where all is built before anything runs.
pub(super) const FOR_BUILDING: f64 = 0.3;

/// Share of a section's time after which nothing runs for the first time.
pub(super) const FOR_FIRST_RUNS: f64 = 0.5;

/// How often a configuration ran.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Ran {
    /// In turn with the others, often enough to be compared.
    #[default]
    InTurn,
    /// The same, but not to the last round, as it is clearly slower than the fastest.
    UntilClear,
    /// Once, as it is slow.
    Once,
    /// Not to the end: it was stopped.
    Stopped,
    /// Not at all, as no time was left.
    Never,
}

/// Times of a configuration.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    /// One per round; `None` if the clock had no valid time.
    runs: Vec<Option<f64>>,
    ran: Ran,
}

/// A configuration's first run, which also warms up.
#[derive(Clone, Copy, Debug)]
pub(super) struct First {
    /// `None` if no time was left for it.
    ended: Option<Ended>,
    spent: Duration,
}

impl First {
    /// Its time; `None` if it did not run, or was stopped.
    pub(super) fn time(&self) -> Option<Time> {
        match self.ended {
            Some(Ended::Done(time)) => Some(time),
            Some(Ended::GivenUp) | None => None,
        }
    }

    /// Whether there was no time for it, so that the renderer has no results.
    pub(super) fn is_missing(&self) -> bool {
        self.ended.is_none()
    }
}

impl Times {
    /// Times that were measured otherwise: one per round.
    pub(super) fn of(runs: Vec<Option<f64>>) -> Self {
        Self { runs, ran: Ran::InTurn }
    }

    fn known(&self) -> Vec<f64> {
        fill::known(&self.runs)
    }

    /// Whether it ran in turn with others, and can be compared with them.
    pub(super) fn is_timed(&self) -> bool {
        matches!(self.ran, Ran::InTurn | Ran::UntilClear)
    }

    /// Whether a run was stopped: then there are no times, and the streams are incomplete.
    pub(super) fn is_given_up(&self) -> bool {
        self.ran == Ran::Stopped
    }

    /// Whether it did not run, so that there are no results.
    pub(super) fn is_missing(&self) -> bool {
        self.ran == Ran::Never
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
        Self { runs: wanted.collect(), ran: self.ran }
    }

    /// Its runs with the other's runs of the same rounds, where both have a time; none unless both ran in turn.
    pub(super) fn pairs<'t>(&'t self, to: &'t Self) -> impl Iterator<Item = (f64, f64)> + 't {
        fill::pairs(self.in_turn(), to.in_turn())
    }

    /// How much longer each run took than the other's run of the same round, in nanoseconds.
    pub(super) fn differences(&self, to: &Self) -> Vec<f64> {
        self.pairs(to).map(|(a, b)| a - b).collect()
    }

    /// The median ratio to the other's runs of the same rounds, with its interval if there are enough.
    pub(super) fn ratio(&self, to: &Self, seed: u32) -> Option<(f64, Option<Interval>)> {
        fill::ratio_of(self.in_turn(), to.in_turn(), seed)
    }

    /// Fills the columns of times.
    pub(super) fn fill(&self, row: Row, seed: u32) -> Row {
        fill::times(row, &self.runs, seed)
    }

    /// Fills the columns of the ratio to another configuration.
    pub(super) fn fill_ratio(&self, to: &Self, name: &str, row: Row, seed: u32) -> Row {
        fill::ratio(row, self.in_turn(), to.in_turn(), name, seed)
    }

    fn in_turn(&self) -> &[Option<f64>] {
        if self.is_timed() { &self.runs } else { &[] }
    }
}

/// Notes on what could not be timed within the section's time, by name.
pub(super) fn notes<'a>(work: &Work<'_>, all: impl Iterator<Item = (String, &'a Times)>) -> Vec<String> {
    let (mut until_clear, mut once, mut never) = (Vec::new(), Vec::new(), Vec::new());
    for (name, times) in all {
        match times.ran {
            Ran::UntilClear => until_clear.push(format!("{name} ({} runs)", times.runs())),
            Ran::Once => once.push(name),
            Ran::Never => never.push(name),
            Ran::InTurn | Ran::Stopped => {}
        }
    }
    let note = |names: Vec<String>, what: &str| {
        (!names.is_empty()).then(|| format!("{what} {} (--seconds): {}", work.time_in_words(), names.join(", ")))
    };
    let notes = [
        note(until_clear, "clearly slower than the fastest, so given fewer runs, to stay within"),
        note(once, "slow, so run only once and not compared, to stay within"),
        note(never, "left out, to stay within"),
    ];
    notes.into_iter().flatten().collect()
}

impl Work<'_> {
    /// Runs a configuration for the first time, unless half of the section's time is over.
    pub(super) async fn first_run(&self, renderer: &mut Renderer) -> Result<First, Error> {
        let begin = Instant::now();
        let ended = if self.is_past(FOR_FIRST_RUNS) { None } else { Some(self.run(renderer).await?) };
        Ok(First { ended, spent: begin.elapsed() })
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

    /// The same with a minimum number of rounds.
    pub(super) async fn time_rounds(
        &self,
        names: &[String],
        renderers: &mut [&mut Renderer],
        fewest: usize,
        repeats: usize,
    ) -> Result<Vec<Times>, Error> {
        let mut firsts = Vec::new();
        let count = renderers.len() as u64;
        for (done, renderer) in (0..).zip(renderers.iter_mut()) {
            self.reporter.part("first runs", done, count);
            firsts.push(self.first_run(renderer).await?);
        }
        self.time_after(&firsts, names, renderers, Amount { fewest, repeats, race: None }).await
    }

    /// The same after the first runs.
    pub(super) async fn time_after(
        &self,
        firsts: &[First],
        names: &[String],
        renderers: &mut [&mut Renderer],
        amount: Amount<'_>,
    ) -> Result<Vec<Times>, Error> {
        let (left, begin) = (self.left(), Instant::now());
        let kept = fitting(firsts, amount, left);
        let all = REPEATS_TAKE * kept.len() as u32;
        let all = left.map_or(all, |left| left.min(all));
        let fewest = amount.fewest_in_turn().min(amount.repeats);
        let turns = Turns { all: Some(all), fewest, seed: u64::from(self.seed()), ..Turns::of(0, amount.repeats) };
        let of = (amount.repeats * kept.len()) as u64;
        let (mut rounds, mut done) = (Rounds::new(kept.len(), turns), 0);
        while let Some(subject) = rounds.next_subject() {
            self.reporter.part("timing", done, of);
            done += 1;
            rounds.ended(self.run(renderers[kept[subject]]).await?);
            let Some(race) = amount.race.filter(|_| rounds.is_round_over()) else { continue };
            if left.is_some_and(|left| begin.elapsed() > left) && rounds.begun() >= amount.fewest {
                break;
            }
            if !will_fit(&rounds, amount.repeats, begin.elapsed(), all) {
                let slower = self.clearly_slower(&rounds, race, &kept);
                slower.into_iter().for_each(|subject| rounds.leave(subject));
            }
        }
        let mut times: Vec<Times> =
            firsts.iter().zip(names).map(|(first, name)| self.after_first(first, name)).collect();
        let most = rounds.times().iter().map(|of| of.runs.len()).max().unwrap_or(0);
        for (i, in_turn) in kept.into_iter().zip(rounds.into_times()) {
            let ran = match in_turn.runs.len() < most {
                _ if in_turn.is_given_up => Ran::Stopped,
                true => Ran::UntilClear,
                false => Ran::InTurn,
            };
            let runs = if in_turn.is_given_up { Vec::new() } else { in_turn.runs };
            times[i] = Times { runs: self.recorded(&names[i], &runs), ran };
        }
        Ok(times)
    }

    /// Which subjects of rounds are clearly slower than the fastest; they are configurations that were `kept`.
    fn clearly_slower(&self, rounds: &Rounds, race: Race<'_>, kept: &[usize]) -> Vec<usize> {
        let times_of = |(times, &i): (&meter::Times, &usize)| {
            let known = times.runs.iter().filter_map(|run| self.ns(run.time)).collect();
            (race.can_win.get(i) == Some(&true), known)
        };
        clearly_slower(&rounds.times().iter().zip(kept).map(times_of).collect::<Vec<_>>())
    }

    /// The times of a configuration that is not run again.
    fn after_first(&self, first: &First, name: &str) -> Times {
        match first.ended {
            Some(Ended::Done(time)) => {
                Times { runs: self.recorded(name, &[Run { round: 0, place: 0, time }]), ran: Ran::Once }
            }
            Some(Ended::GivenUp) => Times { runs: Vec::new(), ran: Ran::Stopped },
            None => Times { runs: Vec::new(), ran: Ran::Never },
        }
    }

    /// Records runs, and returns their times.
    fn recorded(&self, name: &str, runs: &[Run]) -> Vec<Option<f64>> {
        self.record.add_runs(runs.iter().map(|run| {
            let row = self.row(RUN_COLUMNS).set("section", self.section).set("configuration", name);
            self.meter.fill_run(run, row)
        }));
        runs.iter().map(|run| self.ns(run.time)).collect()
    }

    /// The time of a run, if it had a valid one.
    pub(super) fn ns(&self, time: Time) -> Option<f64> {
        self.meter.ns(time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_ran_in_turn_is_compared() {
        let times = |ran| Times { runs: vec![Some(2.0); 6], ran };
        let ratio = |of, to| times(of).ratio(&times(to), 1).map(|(ratio, _)| ratio);
        assert_eq!(ratio(Ran::InTurn, Ran::InTurn), Some(1.0));
        assert_eq!(ratio(Ran::UntilClear, Ran::InTurn), Some(1.0));
        assert_eq!((ratio(Ran::Once, Ran::InTurn), ratio(Ran::InTurn, Ran::Once)), (None, None));
    }
}
