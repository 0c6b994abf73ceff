//! What the lines of a kernel took.

use std::collections::BTreeMap;

use super::compile::line_of;
use super::{Interpreter, Work};

/// What a line of the composed source took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineWork {
    /// How often it ran: the statement or condition of it that ran most often.
    pub runs: u64,
    /// What it took, in all of these runs.
    pub work: Work,
}

impl Interpreter {
    /// What the lines of the composed source took, by line from 0, of statements that ran so often: see
    /// [`Many::runs`](super::Many::runs) and [`Passed::runs`](super::pass::Passed::runs).
    #[must_use]
    pub fn by_line(&self, runs: &[u64]) -> BTreeMap<usize, LineWork> {
        let mut lines: BTreeMap<usize, LineWork> = BTreeMap::new();
        let mut known: Option<(usize, usize)> = None;
        // Most neighbours are on one line or near it.
        let mut line_at = |byte: usize| {
            let line = match known {
                Some((at, line)) if at <= byte => line + line_of(&self.source[at..], byte - at),
                _ => line_of(&self.source, byte),
            };
            known = Some((byte, line));
            line
        };
        for (statement, (span, &times)) in self.code.statements.iter().zip(runs).enumerate() {
            if span.is_empty() || self.source.get(span.clone()).is_none() {
                continue;
            }
            let line = lines.entry(line_at(span.start)).or_default();
            line.runs = line.runs.max(times);
            line.work.add(&self.code.costs[statement], times);
        }
        for (statement, byte, cost) in &self.code.parts {
            let times = runs.get(*statement as usize).copied().unwrap_or_default();
            let line = lines.entry(line_at((*byte).min(self.source.len()))).or_default();
            line.runs = line.runs.max(times);
            line.work.add(cost, times);
        }
        lines
    }
}
