//! The first passes of a run on the CPU reference, the others on the session's device.

use std::ops::ControlFlow;

use raystep_kernels::{Device, Progress, RenderError, Renderer};

use super::travel::Guide;
use super::{OnProgress, Session};

/// The CPU reference in f32, and the number of its passes.
pub(super) struct Twins {
    renderer: Renderer,
    /// Number of its passes.
    pub(super) until: usize,
    /// Whether it is at the place of the session's run, with the same streams.
    is_in_step: bool,
}

impl Twins {
    /// Runs passes up to `stop`, or to the last of the CPU reference, and copies streams and place to `renderer`.
    pub(super) async fn run_to(
        &mut self,
        renderer: &mut Renderer,
        stop: usize,
        tell: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<(), RenderError> {
        if !self.is_in_step {
            self.renderer.adopt(renderer).await?;
        }
        self.is_in_step = false;
        let result = self.renderer.run_to(stop.min(self.until), tell).await;
        renderer.adopt(&mut self.renderer).await?;
        self.is_in_step = true;
        result
    }
}

impl Session {
    /// How many of the first passes run on the CPU reference.
    #[must_use]
    pub fn twin_passes(&self) -> Option<usize> {
        self.twins.as_ref().map(|twins| twins.until)
    }

    /// Assigns the first `passes` passes to the CPU reference in f32; those after them run on the session's device,
    /// starting from its streams. `None`: all passes run on the device. The session stays at its place, as far as the
    /// run allows; returns the place reached.
    ///
    /// # Errors
    /// As [`step`](Self::step); the assignment takes effect even if that was cancelled.
    pub async fn twins_until(
        &mut self,
        passes: Option<usize>,
        progress: &mut OnProgress<'_>,
    ) -> Result<usize, RenderError> {
        let (before, after) = (self.twin_passes().unwrap_or(0), passes.unwrap_or(0));
        match (passes, &mut self.twins) {
            (None, twins) => *twins = None,
            (Some(until), Some(twins)) => twins.until = until,
            (Some(until), twins) => {
                let (plan, data) = (self.renderer.shared_plan(), self.renderer.shared_data());
                let renderer = Renderer::from_plan(plan, data, &self.options, &Device::Cpu(None)).await?;
                *twins = Some(Twins { renderer, until, is_in_step: false });
            }
        }
        let here = self.place();
        let same = before.min(after);
        if before != after && here > same {
            self.is_settled = false;
            self.history.forget_after(same);
            self.go(here, &mut Guide::new(progress)).await?;
        } else if before != after {
            self.history.forget_after(same);
        }
        Ok(self.place())
    }

    /// The session's run has moved.
    pub(super) fn leave_twins(&mut self) {
        if let Some(twins) = &mut self.twins {
            twins.is_in_step = false;
        }
    }
}
