//! What a comparison with the truth found, ray by ray and counted.

use std::fmt;

use raystep_kernels::export::json::CheckSummary;

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

/// A ray that is not right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mistake {
    /// Its place, y * width + x.
    pub ray: usize,
    /// What is wrong.
    pub verdict: Verdict,
    /// The triangle and t that were found, if any.
    pub found: Option<(u32, f32)>,
    /// The exact triangle and t, if any.
    pub exact: Option<(u32, f64)>,
}

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Rays compared.
    pub rays: u64,
    /// Rays with the exact result.
    pub same: u64,
    /// Rays with another result that f32 cannot exclude.
    pub ties: u64,
    /// Those of the ties that hit nothing: every edge function that could decide was 0 or within its bound.
    pub unresolved: u64,
    /// Rays that missed.
    pub missed: u64,
    /// Rays that hit where nothing is.
    pub false_hits: u64,
    /// Rays that hit the wrong triangle or at the wrong t.
    pub wrong: u64,
    /// Largest error of t among right hits, in units in the last place of the depth of the triangle's
    /// farthest corner: that is what the arithmetic rounds, however near the hit is.
    pub largest_t_ulp: f64,
    /// The first mistakes, at most 64.
    pub mistakes: Vec<Mistake>,
    /// True where the comparison was stopped before its end.
    pub is_partial: bool,
}

impl Report {
    /// Missed, false and wrong together.
    #[must_use]
    pub fn errors(&self) -> u64 {
        self.missed + self.false_hits + self.wrong
    }

    pub(super) fn add(&mut self, mistake: Mistake, t_ulp: f64) {
        self.rays += 1;
        self.largest_t_ulp = self.largest_t_ulp.max(t_ulp);
        match mistake.verdict {
            Verdict::Same => self.same += 1,
            Verdict::Tie => {
                self.ties += 1;
                self.unresolved += u64::from(mistake.found.is_none());
            }
            Verdict::Missed => self.missed += 1,
            Verdict::False => self.false_hits += 1,
            Verdict::Wrong => self.wrong += 1,
        }
        let is_error = !matches!(mistake.verdict, Verdict::Same | Verdict::Tie);
        if is_error && self.mistakes.len() < 64 {
            self.mistakes.push(mistake);
        }
    }

    pub(super) fn merge(&mut self, other: Self) {
        self.rays += other.rays;
        self.same += other.same;
        self.ties += other.ties;
        self.unresolved += other.unresolved;
        self.missed += other.missed;
        self.false_hits += other.false_hits;
        self.wrong += other.wrong;
        self.largest_t_ulp = self.largest_t_ulp.max(other.largest_t_ulp);
        self.mistakes.extend(other.mistakes);
        self.mistakes.truncate(64);
    }
}

impl From<&Report> for CheckSummary {
    fn from(report: &Report) -> Self {
        let Report { rays, same, ties, missed, false_hits, wrong, largest_t_ulp, .. } = *report;
        Self { rays, same, ties, missed, false_hits, wrong, largest_t_ulp }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} rays against f64 brute force: {} missed, {} false, {} wrong, {} ties ({:.4}%), t within {:.1} ulp",
            self.rays,
            self.missed,
            self.false_hits,
            self.wrong,
            self.ties,
            100.0 * self.ties as f64 / self.rays.max(1) as f64,
            self.largest_t_ulp
        )
    }
}
