//! The steps of one thread.

/// A step: a thread before a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// The statement, see [`Sourced::statement`](crate::shader::Sourced::statement).
    pub statement: u32,
    /// Number of calls around it.
    pub depth: u32,
}

/// Most steps that are kept, of 8 bytes each.
const MOST_KEPT: usize = 1 << 22;

/// The steps of a thread, or how far it is to run.
#[derive(Debug, Default)]
pub(super) struct Trace {
    pub(super) steps: Vec<Step>,
    /// Steps at which a stop's condition held, and the stop.
    pub(super) held: Vec<(usize, usize)>,
    /// How often that of each stop did so far.
    counts: Vec<u32>,
    /// There were more steps.
    pub(super) is_cut: bool,
    /// The step to which the thread is run.
    until: Option<usize>,
    count: usize,
}

impl Trace {
    /// Runs a thread to a step.
    pub(super) fn until(step: usize) -> Self {
        Self { until: Some(step), ..Self::default() }
    }

    /// Whether the next step is where it is to be run to; always, if it is run to its end.
    pub(super) fn is_next(&self) -> bool {
        self.until.is_none_or(|until| until == self.count)
    }

    /// Whether it was run there.
    pub(super) fn is_there(&self) -> bool {
        self.until.is_some_and(|until| self.count > until)
    }

    /// The thread begins a statement. Returns whether it is where it was to be run to.
    pub(super) fn step(&mut self, statement: u32, depth: u32) -> bool {
        if let Some(until) = self.until {
            self.count += 1;
            return self.count > until;
        }
        if self.steps.len() < MOST_KEPT && self.steps.try_reserve(1).is_ok() {
            self.steps.push(Step { statement, depth });
        } else {
            self.is_cut = true;
        }
        false
    }

    /// The thread has come to a stop, whose condition has held so often.
    pub(super) fn stop(&mut self, stop: usize, held: u32) {
        if self.counts.len() <= stop {
            self.counts.resize(stop + 1, 0);
        }
        let before = std::mem::replace(&mut self.counts[stop], held);
        if held > before && !self.is_cut {
            self.held.push((self.steps.len(), stop));
        }
    }
}
