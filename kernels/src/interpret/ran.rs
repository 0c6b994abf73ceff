//! What is known once an element has run: its recording, and where it stopped.

use super::machine::Machine;
use super::recording::Recording;
use super::{InterpretError, deciding};

impl Machine<'_> {
    /// The recording, with the decision that the new state is due to.
    pub(super) fn finish(mut self) -> Result<Recording, InterpretError> {
        let unrecorded = || InterpretError::Unsupported { what: "no recording".into(), line: 0 };
        let mut recording = self.thread.recording.take().ok_or_else(unrecorded)?;
        let kernel = self.kernel;
        let written = |&component: &usize| self.written[component];
        let nodes: Vec<u32> = (0..self.row.len()).filter(written).map(|component| self.row[component].from).collect();
        let state = kernel.tag().filter(written).map(|tag| self.row[tag].from);
        recording.deciding = deciding::deciding(&recording, &kernel.code.sites, state.as_slice(), &nodes);
        let line = |&statement: &u32| {
            let span = kernel.code.statements.get(statement as usize)?;
            Some(super::compile::line_of(&kernel.source, span.start))
        };
        recording.noted.clone_from(&self.thread.noted);
        recording.stored = self.stored.iter().map(line).collect();
        let callers = |component: usize| -> Vec<usize> {
            recording.calls.get(&component).into_iter().flatten().rev().filter_map(line).collect()
        };
        recording.callers = (0..self.stored.len()).map(callers).collect();
        recording.non_finite = self.non_finite(&recording, &self.before);
        Ok(recording)
    }

    /// The line of the statement that was run last, from 1.
    pub(super) fn line(&self) -> usize {
        self.line_of(self.thread.at)
    }

    fn line_of(&self, statement: u32) -> usize {
        let span = self.kernel.code.statements.get(statement as usize);
        span.map_or(0, |span| super::compile::line_of(&self.kernel.source, span.start) + 1)
    }

    /// That line, and those of the calls that lead to it, the last one first.
    pub(super) fn lines(&self) -> Vec<usize> {
        let calls = self.thread.calls.iter().rev().map(|&statement| self.line_of(statement));
        std::iter::once(self.line()).chain(calls).collect()
    }
}
