//! Two builds in one run. In every round each configuration is run by both, one right after the other, in an order that
//! a coin decides; the logarithm of the ratio of the two times is one value.
//!
//! The test is that of signs ([`sign`]). If the builds are equal, swapping them changes nothing, so that the ratio lies
//! above 1 with probability 1/2 at most in every round, whatever the noise: it may have heavy tails, drift from round to
//! round and be common to all rows. No other property of the times is used. Wilcoxon's signed ranks would need a
//! symmetric distribution about the true ratio, and a t-test light tails; the sign test is also the better one where the
//! noise has heavy tails. Its bounds are order statistics of the ratios.
//!
//! Rows are tested together: a row fails by Holm's adjustment (1979), which keeps the probability that any row fails
//! wrongly; all rows must pass, each at the full level, which needs no adjustment (Berger 1982).
//!
//! After a quarter and a half of the rounds there is an early look, and at the end the last. Each of the three has a third
//! of the level (Bonferroni), so that looking more often makes no error likelier.
//!
//! A process can be slow as a whole, by where its memory lies. Rounds are therefore divided into [`SITTINGS`], each with
//! new processes for both builds, and nothing is decided before two of them are over.

use super::{LEVEL, Times, Verdict};
use crate::rays::Random;
use crate::statistics::{median, proportion, sign};

/// Number of times that new processes are started.
pub const SITTINGS: usize = 8;
/// Number of looks at the results.
const LOOKS: usize = 3;

/// How rounds are divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Looks {
    /// Most rounds.
    pub most: usize,
}

impl Looks {
    /// The level of each look.
    #[must_use]
    pub fn level() -> f64 {
        LEVEL / LOOKS as f64
    }

    /// The rounds of a sitting, from 0; empty if there are fewer sittings.
    #[must_use]
    pub fn rounds(self, sitting: usize) -> std::ops::Range<usize> {
        let size = self.most.div_ceil(SITTINGS).max(1);
        (sitting * size).min(self.most)..((sitting + 1) * size).min(self.most)
    }

    /// Whether the results are looked at after this sitting.
    #[must_use]
    pub fn is_look(self, sitting: usize) -> bool {
        let end = self.rounds(sitting).end;
        end == self.most || sitting == SITTINGS / 4 - 1 || sitting == SITTINGS / 2 - 1
    }
}

/// The order of a round: configurations in random order, and for each whether the other build runs first.
#[must_use]
pub fn order(configurations: usize, random: &mut Random) -> Vec<(usize, bool)> {
    let mut order: Vec<usize> = (0..configurations).collect();
    random.shuffle(&mut order);
    order.into_iter().map(|i| (i, random.below(2) == 0)).collect()
}

/// Judges all rows together. `logs` has the logarithms of each row's ratios, this build's time divided by the other's;
/// `level` is that of this look.
#[must_use]
pub fn judge(logs: &[Vec<f64>], at_most: f64, level: f64) -> Vec<Times> {
    let limit = at_most.ln();
    let p: Vec<[f64; 2]> = logs.iter().map(|logs| sign::p_values(logs, limit)).collect();
    let p_slower: Vec<f64> = p.iter().map(|p| p[0]).collect();
    let adjusted = proportion::holm(&p_slower);
    let (all, levels) = (logs.len(), levels(&p_slower, level));
    let row = |place: usize| {
        let logs = &logs[place];
        let [low, high] = sign::bounds(logs, [levels[place], level]).map(|bound| bound.map(f64::exp));
        let verdict = match (adjusted[place] <= level, p[place][1] <= level) {
            (true, _) => Verdict::Fail,
            (_, true) => Verdict::Pass,
            _ => Verdict::Undecided,
        };
        // The next run has the same looks; a row that leans to failing is tested against all others.
        let leans_to_fail = median(logs).is_some_and(|m| m > limit);
        let strict = if leans_to_fail { level / all as f64 } else { level };
        let needed = || sign::needed(logs, limit, strict);
        Times {
            time_ratio: median(logs).map(f64::exp),
            time_ratio_low: low,
            time_ratio_high: high,
            p_slower: Some(adjusted[place]),
            p_within: Some(p[place][1]),
            verdict,
            needed_repeats: if verdict == Verdict::Undecided { needed() } else { None },
        }
    };
    (0..logs.len()).map(row).collect()
}

/// The level at which Holm's procedure tests each row: a lower bound at this level exceeds the limit exactly if the row
/// fails. Rows after the first that does not fail are at the level of that one.
fn levels(p_slower: &[f64], level: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_slower.len()).collect();
    order.sort_by(|&a, &b| p_slower[a].total_cmp(&p_slower[b]));
    let at = |rank: usize| level / (p_slower.len() - rank) as f64;
    let first_kept = order.iter().enumerate().position(|(rank, &row)| p_slower[row] > at(rank));
    let mut levels = vec![level; p_slower.len()];
    for (rank, &row) in order.iter().enumerate() {
        levels[row] = at(first_kept.map_or(rank, |first| first.min(rank)));
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sittings_cover_all_rounds_and_the_last_is_a_look() {
        for most in [1, 2, 7, 8, 40, 41, 100] {
            let looks = Looks { most };
            let sittings: Vec<_> = (0..).map(|s| looks.rounds(s)).take_while(|rounds| !rounds.is_empty()).collect();
            assert!(sittings.len() <= SITTINGS && sittings[0].start == 0, "{most}: {sittings:?}");
            assert!(sittings.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert_eq!(sittings.last().map(|rounds| rounds.end), Some(most));
            let at: Vec<usize> = (0..sittings.len()).filter(|&s| looks.is_look(s)).map(|s| sittings[s].end).collect();
            assert!(at.len() <= LOOKS && at.last() == Some(&most), "{most}: {at:?}");
            if most == 40 {
                assert_eq!(at, [10, 20, 40]);
            }
        }
    }

    #[test]
    fn bounds_and_verdicts_agree() {
        let mut random = Random::new(4);
        let mut seen = [0; 3];
        for trial in 0..300 {
            let rows = 1 + random.below(5);
            let mut row = |shift: f64| (0..30).map(|_| shift + 0.2 * (random.unit() - 0.5)).collect::<Vec<f64>>();
            let logs: Vec<_> = (0..rows).map(|i| row(0.06 * ((trial + i) % 4) as f64)).collect();
            for times in judge(&logs, 1.1, 0.05) {
                let (low, high) = (times.time_ratio_low.expect("30 values"), times.time_ratio_high.expect("30 values"));
                assert_eq!(low > 1.1, times.verdict == Verdict::Fail, "{times:?}");
                assert_eq!(high < 1.1, times.verdict == Verdict::Pass, "{times:?}");
                seen[times.verdict as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
    }

    #[test]
    fn few_rounds_decide_nothing_and_say_how_many_would() {
        let slow = vec![0.5; 4];
        let times = judge(&[slow.clone(), slow], 1.05, 0.05);
        assert_eq!((times[0].verdict, times[0].needed_repeats), (Verdict::Undecided, Some(6)));
        assert_eq!((times[0].time_ratio_low, times[0].time_ratio_high), (None, None));
        assert_eq!(judge(&[Vec::new()], 1.05, 0.05)[0].verdict, Verdict::Undecided);
    }

    #[test]
    fn either_build_is_first_about_half_the_time() {
        let mut random = Random::new(2);
        let first = (0..500).flat_map(|_| order(4, &mut random)).filter(|(_, other_first)| *other_first).count();
        // Four standard deviations of 2,000 coins are 90.
        assert!(first.abs_diff(1_000) < 90, "{first} of 2,000");
        let mut places: Vec<usize> = order(9, &mut random).into_iter().map(|(i, _)| i).collect();
        places.sort_unstable();
        assert_eq!(places, (0..9).collect::<Vec<_>>());
    }
}
