//! Which configurations get how many runs, where time is short.

use std::time::Duration;

use super::First;
use crate::meter::{Ended, Rounds};
use crate::statistics::interval;

/// How many rounds are measured.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Amount<'a> {
    /// The fewest of every configuration that is compared.
    pub(in crate::report) fewest: usize,
    /// The most.
    pub(in crate::report) repeats: usize,
    /// Where it matters which one is the fastest.
    pub(in crate::report) race: Option<Race<'a>>,
}

/// A search for the fastest: what is clearly slower leaves the time to the others.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Race<'a> {
    /// Whether a configuration can be the one that is looked for.
    pub(in crate::report) can_win: &'a [bool],
    /// The fewest rounds of what is not clearly slower, as far as there is time.
    pub(in crate::report) fewest: usize,
}

/// What takes more than this multiple of the fastest's time is clearly slower.
const CLEARLY: u32 = 2;

impl Amount<'_> {
    /// The fewest rounds, time limits aside.
    pub(super) fn fewest_in_turn(&self) -> usize {
        self.race.map_or(self.fewest, |race| race.fewest.max(self.fewest))
    }
}

/// The configurations of which the fewest rounds fit into the time, without the slowest; at least one. What is clearly
/// slower is among them only if it leaves the others as many as a race wants.
pub(super) fn fitting(firsts: &[First], amount: Amount<'_>, left: Option<Duration>) -> Vec<usize> {
    let is_done = |i: &usize| matches!(firsts[*i].ended, Some(Ended::Done(_)));
    let mut done: Vec<usize> = (0..firsts.len()).filter(is_done).collect();
    let Some(left) = left else { return done };
    done.sort_by_key(|&i| firsts[i].spent);
    let slow = amount.race.and_then(|race| {
        let fastest = done.iter().find(|&&i| race.can_win.get(i) == Some(&true))?;
        Some(CLEARLY * firsts[*fastest].spent)
    });
    let [mut others, mut slower] = [Duration::ZERO; 2];
    let mut fits = |i: usize| {
        let spent = firsts[i].spent;
        if slow.is_none_or(|slow| spent <= slow) {
            others += spent;
            return others * amount.fewest as u32 <= left;
        }
        slower += spent;
        others * amount.fewest_in_turn() as u32 + slower * amount.fewest as u32 <= left
    };
    let count = done.iter().take_while(|&&i| fits(i)).count();
    done.truncate(count.max(1));
    done.sort_unstable();
    done
}

/// The times so far of configurations that take turns, by whether they can win; which of them are clearly slower than the
/// fastest that can: the interval of its median ends below half of theirs. None, as long as there are no intervals.
pub(super) fn clearly_slower(times: &[(bool, Vec<f64>)]) -> Vec<usize> {
    let intervals: Vec<_> = times.iter().map(|(can_win, times)| (*can_win, interval::of_median(times, 0))).collect();
    let of_fastest = intervals.iter().filter(|(can_win, _)| *can_win).filter_map(|(_, interval)| *interval);
    let Some(fastest) = of_fastest.min_by(|a, b| a.median.total_cmp(&b.median)) else { return Vec::new() };
    let is_slower = |i: &usize| intervals[*i].1.is_some_and(|own| own.low > f64::from(CLEARLY) * fastest.high);
    (0..times.len()).filter(is_slower).collect()
}

/// Whether all rounds that are wanted will fit into the time if they take as long as those that are over.
pub(super) fn will_fit(rounds: &Rounds, repeats: usize, spent: Duration, all: Duration) -> bool {
    let done = rounds.begun().max(1) as u32;
    spent + spent / done * (repeats as u32).saturating_sub(done) <= all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meter::Time;

    const fn ms(spent: u64) -> Duration {
        Duration::from_millis(spent)
    }

    fn first(spent: u64, ended: Option<Ended>) -> First {
        First { ended, spent: ms(spent) }
    }

    const DONE: Option<Ended> = Some(Ended::Done(Time { wall_ns: 1, device_ns: None }));
    const SIX: Amount<'_> = Amount { fewest: 6, repeats: 24, race: None };

    #[test]
    fn the_slowest_run_once_if_the_fewest_rounds_of_all_would_take_too_long() {
        let firsts =
            [first(40, DONE), first(10, DONE), first(1, None), first(5, Some(Ended::GivenUp)), first(20, DONE)];
        assert_eq!(fitting(&firsts, SIX, None), [0, 1, 4]);
        assert_eq!(fitting(&firsts, SIX, Some(ms(420))), [0, 1, 4]);
        assert_eq!(fitting(&firsts, SIX, Some(ms(419))), [1, 4]);
        assert_eq!(fitting(&firsts, SIX, Some(ms(179))), [1]);
        assert_eq!(fitting(&firsts, SIX, Some(ms(0))), [1], "one is always timed");
        assert!(fitting(&firsts[2..4], SIX, Some(ms(9))).is_empty());
    }

    #[test]
    fn what_is_clearly_slower_runs_once_if_it_takes_the_rounds_of_the_others() {
        // The fastest cannot win; two that can are close, and one is slow.
        let firsts = [first(4, DONE), first(10, DONE), first(20, DONE), first(100, DONE)];
        let race = Some(Race { can_win: &[false, true, true, true], fewest: 12 });
        let fitting = |left| fitting(&firsts, Amount { race, ..SIX }, Some(ms(left)));
        // Twelve rounds of 34 ms and six of 100 ms.
        assert_eq!(fitting(1008), [0, 1, 2, 3]);
        assert_eq!(fitting(1007), [0, 1, 2]);
        // What is close is compared even if there is only time for six rounds.
        assert_eq!((fitting(204), fitting(203)), (vec![0, 1, 2], vec![0, 1]));
    }

    #[test]
    fn clearly_slower_is_what_lies_above_twice_the_fastest_that_can_win() {
        let times = |can_win, low: f64, high: f64| (can_win, vec![low, low, low, high, high, high]);
        let all = [times(false, 1.0, 1.0), times(true, 10.0, 12.0), times(true, 24.0, 40.0), times(false, 25.0, 26.0)];
        assert_eq!(clearly_slower(&all), [3]);
        assert!(clearly_slower(&[times(false, 1.0, 1.0), times(false, 9.0, 9.0)]).is_empty());
        // Five runs have no interval.
        assert!(clearly_slower(&[times(true, 1.0, 1.0), (true, vec![9.0; 5])]).is_empty());
        assert!(clearly_slower(&[(true, vec![1.0; 5]), times(true, 9.0, 9.0)]).is_empty());
    }
}
