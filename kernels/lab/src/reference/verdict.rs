//! What became of a ray, and of how many what.

/// What became of one ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The exact triangle, or rightly none.
    Same,
    /// Not the exact one, but f32 could not tell.
    Tie,
    /// Nothing was hit, and something was there.
    Missed,
    /// Something was hit, and nothing was there.
    False,
    /// Another triangle than the nearest, or its t is off by more than its bound.
    Wrong,
}

impl Verdict {
    /// Whether it is an error; what f32 cannot decide is none.
    #[must_use]
    pub fn is_error(self) -> bool {
        matches!(self, Self::Missed | Self::False | Self::Wrong)
    }
}

/// A ray, what it found and what it should have found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mistake {
    /// Its place, y * width + x.
    pub ray: usize,
    /// What is wrong, if anything.
    pub verdict: Verdict,
    /// The triangle and t that were found, if any.
    pub found: Option<(u32, f32)>,
    /// The exact triangle and t, if any.
    pub exact: Option<(u32, f64)>,
}

/// Rays by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays with the exact result.
    pub same: u64,
    /// Rays with another result that f32 cannot exclude.
    pub ties: u64,
    /// Rays that missed.
    pub missed: u64,
    /// Rays that hit where nothing is.
    pub false_hits: u64,
    /// Rays that hit the wrong triangle or at the wrong t.
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

    /// All of them.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.same + self.ties + self.errors()
    }

    /// Missed, false and wrong together.
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
