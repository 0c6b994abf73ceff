//! Verdicts on rays, and their counts.

use raystep_kernels::named;

/// The verdict on one ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The exact triangle, or correctly none.
    Same,
    /// Not the exact result, but f32 cannot decide.
    Tie,
    /// No hit was found although the exact ray hits a triangle.
    Missed,
    /// A hit was found although the exact ray hits nothing.
    False,
    /// A triangle that is not the nearest, or t is off by more than its bound.
    Wrong,
}

named!(Verdict, Same "same", Tie "undecided", Missed "missed", False "false_hit", Wrong "wrong_hit");

impl Verdict {
    /// Whether it is an error; a tie is not.
    #[must_use]
    pub fn is_error(self) -> bool {
        matches!(self, Self::Missed | Self::False | Self::Wrong)
    }
}

/// A ray with the computed and the exact hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mistake {
    /// The ray's index, y * width + x.
    pub ray: usize,
    /// What is wrong, if anything.
    pub verdict: Verdict,
    /// The computed triangle and t, if any.
    pub found: Option<(u32, f32)>,
    /// The exact triangle and t, if any.
    pub exact: Option<(u32, f64)>,
}

/// Numbers of rays by verdict, as columns of CSV files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Rays with the exact result.
    #[serde(skip)]
    pub same: u64,
    /// Rays with another result, which f32 cannot exclude.
    #[serde(rename = "undecided")]
    pub ties: u64,
    /// Rays that missed.
    pub missed: u64,
    /// Rays that hit although nothing is there.
    pub false_hits: u64,
    /// Rays that hit the wrong triangle or at the wrong t.
    #[serde(rename = "wrong_hits")]
    pub wrong: u64,
}

impl Counts {
    /// Counts one more ray.
    pub fn add(&mut self, verdict: Verdict) {
        *match verdict {
            Verdict::Same => &mut self.same,
            Verdict::Tie => &mut self.ties,
            Verdict::Missed => &mut self.missed,
            Verdict::False => &mut self.false_hits,
            Verdict::Wrong => &mut self.wrong,
        } += 1;
    }

    /// Rays with this verdict.
    #[must_use]
    pub fn of(&self, verdict: Verdict) -> u64 {
        match verdict {
            Verdict::Same => self.same,
            Verdict::Tie => self.ties,
            Verdict::Missed => self.missed,
            Verdict::False => self.false_hits,
            Verdict::Wrong => self.wrong,
        }
    }

    /// The number of rays.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.same + self.ties + self.errors()
    }

    /// The sum of missed, false and wrong.
    #[must_use]
    pub fn errors(&self) -> u64 {
        self.missed + self.false_hits + self.wrong
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.same += other.same;
        self.ties += other.ties;
        self.missed += other.missed;
        self.false_hits += other.false_hits;
        self.wrong += other.wrong;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_verdict_is_counted_as_itself_and_ties_are_no_errors() {
        use Verdict::{False, Missed, Same, Tie, Wrong};
        let mut counts = Counts::default();
        for verdict in [Same, Tie, Tie, Missed, Wrong, Same, False, Wrong, Same, Wrong] {
            counts.add(verdict);
        }
        assert_eq!([Same, Tie, Missed, False, Wrong].map(|v| counts.of(v)), [3, 2, 1, 1, 3]);
        assert_eq!((counts.rays(), counts.errors()), (10, 5));
        assert_eq!([Same, Tie, Missed, False, Wrong].map(Verdict::is_error), [false, false, true, true, true]);
        let mut twice = counts;
        twice += counts;
        assert_eq!([Same, Tie, Missed, False, Wrong].map(|v| twice.of(v)), [6, 4, 2, 2, 6]);
    }
}
