//! The result of judging every ray.

use std::fmt;

use raystep_kernels::export::json::CheckSummary;

use crate::reference::{Counts, Mistake, Verdict};

/// Maximum number of mistakes kept.
const MOST_MISTAKES: usize = 64;

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Rays by verdict.
    pub counts: Counts,
    /// Ties that hit nothing: every edge function that could decide was 0 or within its bound.
    pub unresolved: u64,
    /// Largest error of t among correct hits, in units in the last place of the depth of the triangle's farthest
    /// vertex: that depth determines the rounding, however near the hit is.
    pub largest_t_ulp: f64,
    /// The first mistakes, at most 64.
    pub mistakes: Vec<Mistake>,
    /// Whether the comparison was stopped early.
    pub is_partial: bool,
}

impl Report {
    /// The sum of missed, false and wrong.
    #[must_use]
    pub fn errors(&self) -> u64 {
        self.counts.errors()
    }

    pub(super) fn add(&mut self, mistake: Mistake, t_ulp: f64) {
        self.counts.add(mistake.verdict);
        self.largest_t_ulp = self.largest_t_ulp.max(t_ulp);
        self.unresolved += u64::from(mistake.verdict == Verdict::Tie && mistake.found.is_none());
        if mistake.verdict.is_error() && self.mistakes.len() < MOST_MISTAKES {
            self.mistakes.push(mistake);
        }
    }

    pub(super) fn merge(&mut self, other: Self) {
        self.counts += other.counts;
        self.unresolved += other.unresolved;
        self.largest_t_ulp = self.largest_t_ulp.max(other.largest_t_ulp);
        self.mistakes.extend(other.mistakes);
        self.mistakes.truncate(MOST_MISTAKES);
    }
}

impl From<&Report> for CheckSummary {
    fn from(report: &Report) -> Self {
        let Counts { same, ties, missed, false_hits, wrong } = report.counts;
        let (rays, largest_t_ulp) = (report.counts.rays(), report.largest_t_ulp);
        Self { rays, same, ties, missed, false_hits, wrong, largest_t_ulp }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Counts { ties, missed, false_hits, wrong, .. } = self.counts;
        let rays = self.counts.rays();
        write!(
            f,
            "{rays} rays against f64 brute force: {missed} missed, {false_hits} false, {wrong} wrong, {ties} ties \
             ({:.4}%), t within {:.1} ulp",
            100.0 * ties as f64 / rays.max(1) as f64,
            self.largest_t_ulp
        )
    }
}
