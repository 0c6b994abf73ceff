//! Stops of a kernel: counts how often a thread comes there, and keeps values.

use super::Interpreter;
use super::code::{StopOp, Watched};
use super::machine::{Frame, Machine};
use super::stopped::{MOST_STOPS, Stopped};
use crate::shader::MOST_WATCHED;

impl Interpreter {
    /// The variables of a stop's condition whose values are kept; none if nothing calls the function that it is in.
    #[must_use]
    pub fn watched(&self, stop: usize) -> &[Watched] {
        self.code.stops.get(stop).map_or(&[], Vec::as_slice)
    }
}

impl<'a> Machine<'a> {
    pub(super) fn stop(&mut self, frame: &Frame<'a>, stop: &StopOp) {
        let holds = self.get(frame, stop.condition, 0).bits != 0;
        let index = stop.index.min(MOST_STOPS);
        if self.thread.stopped.len() <= index {
            self.thread.stopped.resize(index + 1, Stopped::default());
        }
        let Stopped { reached, held, .. } = self.thread.stopped[index];
        if reached == 0 || holds && held == 0 {
            let mut values = std::mem::take(&mut self.thread.stopped[index].values);
            values.clear();
            for (watched, at) in stop.watched.iter().take(MOST_WATCHED) {
                values.extend((0..watched.words).map(|lane| self.get(frame, *at, lane).bits));
            }
            self.thread.stopped[index].values = values;
        }
        let stopped = &mut self.thread.stopped[index];
        stopped.reached = reached.saturating_add(1);
        stopped.held = held.saturating_add(holds.into());
    }
}
