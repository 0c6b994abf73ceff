//! Follows one element statement by statement: its steps, and what its variables are at any of them.
//!
//! A kernel is deterministic, so nothing is kept of the way but where it led: to see a step, the element runs again up to it.

use super::machine::Machine;
use super::trace::{Step, Trace};
use super::view::{StreamView, View};
use super::{Element, InterpretError, Interpreter};
use crate::scene_data::SceneData;

/// The steps of an element.
#[derive(Clone, Debug, Default)]
pub struct Followed {
    /// Each statement that it began, in order.
    pub steps: Vec<Step>,
    /// Steps at which the condition of a stop held, and the stop.
    pub held: Vec<(usize, usize)>,
    /// There were more than are kept.
    pub is_cut: bool,
    /// Why it did not come to its end, and the lines of the composed source, from 1, that it ran last: in the function that
    /// ran, in the one that called it, and so on.
    pub failed: Option<(InterpretError, Vec<usize>)>,
}

impl Followed {
    pub(super) fn of(trace: Trace, failed: Option<(InterpretError, Vec<usize>)>) -> Self {
        let Trace { steps, held, is_cut, .. } = trace;
        Self { steps, held, is_cut, failed }
    }
}

impl Interpreter {
    /// The steps of one element of a kernel that [`Sourced::stopping`](crate::shader::Sourced::stopping) has traced.
    #[must_use]
    pub fn follow(&self, data: &SceneData, element: Element, texels: &[u32]) -> Followed {
        let mut machine = Machine::new(self, data, None);
        machine.thread.trace = Some(Box::default());
        let ran = machine.run(element, &mut texels.to_vec());
        let failed = ran.err().map(|why| (why, machine.lines()));
        Followed::of(machine.thread.trace.take().map(|trace| *trace).unwrap_or_default(), failed)
    }

    /// What the element's variables are at a step; behind the last, when it has ended or failed.
    ///
    /// # Errors
    /// If an expression that is evaluated there has no value.
    pub fn view(
        &self,
        data: &SceneData,
        element: Element,
        texels: &[u32],
        step: usize,
    ) -> Result<View, InterpretError> {
        let mut machine = Machine::new(self, data, None);
        machine.thread.trace = Some(Box::new(Trace::until(step)));
        let ran = machine.run(element, &mut texels.to_vec());
        let is_there = machine.thread.trace.as_ref().is_some_and(|trace| trace.is_there());
        if !is_there && self.evaluates() {
            ran?;
        }
        let mut view = machine.view();
        let layers = self.streams.iter().flat_map(|&stream| (0..stream.layers()).map(move |layer| (stream, layer)));
        let values = machine.before.iter().zip(&machine.row);
        view.streams = layers
            .zip(values)
            .map(|((stream, layer), (&before, now))| StreamView { stream, layer, before, now: now.bits })
            .collect();
        Ok(view)
    }
}
