//! The passes of a run as they are written: by the command line, the window and Python alike.

use super::csv::{DrawnPart, PassesCsv, RunContext};
use super::trace_events::{TraceEvents, trace_events};
use crate::executor::DrawTime;
use crate::plan::Plan;
use crate::renderer::{CounterSums, Pass, Renderer};

/// The passes of a run.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    /// What they have in common.
    pub run: &'a RunContext,
    /// The run's plan.
    pub plan: &'a Plan,
    /// The passes, from the first.
    pub passes: &'a [Pass],
    /// The parts of each of them, if they are drawn.
    pub draws: &'a [Vec<DrawTime>],
    /// What each of them has added to the counters; empty if unknown.
    pub counted: &'a [CounterSums],
}

impl<'a> Recorded<'a> {
    /// The passes of a run so far; it keeps them.
    #[must_use]
    pub fn of(run: &'a RunContext, renderer: &'a Renderer, counted: &'a [CounterSums]) -> Self {
        Self { run, plan: renderer.plan(), passes: renderer.passes(), draws: renderer.draws(), counted }
    }

    fn parts(&self, index: usize) -> Vec<DrawnPart> {
        let parts = self.passes.get(index).zip(self.draws.get(index));
        parts.map(|(pass, draws)| DrawnPart::of(self.plan, pass, draws)).unwrap_or_default()
    }

    /// As rows of `passes.csv`.
    ///
    /// # Errors
    /// None: memory does not fail.
    pub fn csv(&self) -> std::io::Result<Vec<u8>> {
        let mut file = Vec::new();
        let mut csv = PassesCsv::new(&mut file)?;
        for (index, pass) in self.passes.iter().enumerate() {
            csv.write(self.run, pass, &self.parts(index), self.counted.get(index).copied())?;
        }
        csv.finish()?;
        Ok(file)
    }

    /// As trace events, for Perfetto.
    #[must_use]
    pub fn trace_events(&self) -> TraceEvents {
        let parts: Vec<_> = (0..self.draws.len()).map(|index| self.parts(index)).collect();
        trace_events(self.run, self.passes, &parts)
    }
}
