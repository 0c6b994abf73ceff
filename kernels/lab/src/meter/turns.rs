//! The order of runs that are compared.

use std::time::Duration;

use web_time::Instant;

use super::{Ended, Run, Times};
use crate::rays::Random;

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

/// Who runs next, and the times so far.
#[derive(Debug)]
pub struct Rounds {
    turns: Turns,
    random: Random,
    begin: Instant,
    /// Rounds that have begun, those of warm-ups included.
    begun: usize,
    /// The order within the current round.
    order: Vec<usize>,
    /// Subjects that had their turn in it.
    place: usize,
    /// When the current run began.
    start: Instant,
    times: Vec<Times>,
    spent: Vec<Duration>,
    /// Whether a subject runs no more.
    has_left: Vec<bool>,
}

impl Rounds {
    /// For this many subjects.
    #[must_use]
    pub fn new(subjects: usize, turns: Turns) -> Self {
        let now = Instant::now();
        Self {
            turns,
            random: Random::new(turns.seed),
            begin: now,
            begun: 0,
            order: (0..subjects).collect(),
            place: subjects,
            start: now,
            times: vec![Times::default(); subjects],
            spent: vec![Duration::ZERO; subjects],
            has_left: vec![false; subjects],
        }
    }

    /// The index of the subject that runs now; `None` at the end. [`ended`](Self::ended) is told of its run next.
    pub fn next_subject(&mut self) -> Option<usize> {
        loop {
            if self.place == self.order.len() && !self.begin_round() {
                return None;
            }
            let Some(&subject) = self.order.get(self.place) else { continue };
            self.place += 1;
            let is_late = self.is_extra() && self.turns.each.is_some_and(|each| self.spent[subject] > each);
            if !self.times[subject].is_given_up && !is_late && !self.has_left[subject] {
                self.start = Instant::now();
                return Some(subject);
            }
        }
    }

    /// How the run of the last [`next_subject`](Self::next_subject) ended. One that was stopped is not run again.
    pub fn ended(&mut self, ended: Ended) {
        let Some(place) = self.place.checked_sub(1) else { return };
        let (subject, counting) = (self.order[place], self.counting());
        match (ended, counting) {
            (Ended::GivenUp, _) => self.times[subject].is_given_up = true,
            (Ended::Done(time), Some(round)) => self.times[subject].runs.push(Run { round, place, time }),
            (Ended::Done(_), None) => {}
        }
        if counting.is_some() {
            self.spent[subject] += self.start.elapsed();
        }
    }

    /// A subject keeps its times, and runs no more.
    pub fn leave(&mut self, subject: usize) {
        self.has_left.get_mut(subject).into_iter().for_each(|has_left| *has_left = true);
    }

    /// Whether all subjects had their turn in the current round.
    #[must_use]
    pub fn is_round_over(&self) -> bool {
        let is_out = |subject: &usize| self.has_left[*subject] || self.times[*subject].is_given_up;
        self.order[self.place..].iter().all(is_out)
    }

    /// Rounds that have begun, those of warm-ups included.
    #[must_use]
    pub fn begun(&self) -> usize {
        self.begun
    }

    /// The times of each subject so far.
    #[must_use]
    pub fn times(&self) -> &[Times] {
        &self.times
    }

    /// The times of each subject.
    #[must_use]
    pub fn into_times(self) -> Vec<Times> {
        self.times
    }

    /// Whether there is another round.
    fn begin_round(&mut self) -> bool {
        let rounds = self.turns.warmups + self.turns.repeats;
        if self.begun == rounds {
            return false;
        }
        self.begun += 1;
        match self.counting() {
            Some(round) if round % 2 == 1 => self.order.reverse(),
            _ => self.random.shuffle(&mut self.order),
        }
        if self.is_extra() && self.turns.all.is_some_and(|all| self.begin.elapsed() > all) {
            self.begun = rounds;
            return false;
        }
        self.place = 0;
        true
    }

    /// The current round, from 0; `None` while warming up.
    fn counting(&self) -> Option<usize> {
        self.begun.checked_sub(self.turns.warmups + 1)
    }

    /// Whether the fewest runs have been made.
    fn is_extra(&self) -> bool {
        self.counting().is_some_and(|done| done >= self.turns.fewest)
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
    let mut rounds = Rounds::new(subjects.len(), turns);
    while let Some(subject) = rounds.next_subject() {
        rounds.ended(run(&mut subjects[subject])?);
    }
    Ok(rounds.into_times())
}

#[cfg(test)]
mod tests {
    use super::super::Time;
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
    fn who_leaves_keeps_its_times_and_holds_up_nobody() {
        let mut rounds = Rounds::new(3, Turns::of(0, 4));
        let mut over = Vec::new();
        while let Some(subject) = rounds.next_subject() {
            rounds.ended(done(subject as u64).expect("a time"));
            over.extend(rounds.is_round_over().then(|| rounds.begun()));
            if rounds.begun() == 2 && rounds.is_round_over() {
                rounds.leave(1);
            }
        }
        assert_eq!(over, [1, 2, 3, 4]);
        let runs = |times: &[Times]| times.iter().map(|times| times.runs.len()).collect::<Vec<_>>();
        assert_eq!((runs(rounds.times()), runs(&rounds.into_times())), (vec![4, 2, 4], vec![4, 2, 4]));
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
}
