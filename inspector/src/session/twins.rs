//! The first passes of a run on the twins, the others on the session's device.

use std::ops::ControlFlow;

use raystep_kernels::{Device, Progress, RenderError, Renderer};

use super::travel::Guide;
use super::{OnProgress, Session};

/// The twins, in f32, and how far they go.
pub(super) struct Twins {
    renderer: Renderer,
    /// Passes that they run.
    pub(super) until: usize,
    /// They are where the session's run is, with the same streams.
    is_in_step: bool,
}

impl Twins {
    /// Runs passes up to `stop`, or as many as are the twins', and hands streams and place to `renderer`.
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
    /// How many of the first passes run on the twins.
    #[must_use]
    pub fn twin_passes(&self) -> Option<usize> {
        self.twins.as_ref().map(|twins| twins.until)
    }

    /// Lets the first `passes` passes run on the twins, in f32, and those after them on the session's device, from
    /// the twins' streams; `None`: all on the device. The session stays where it is, as far as the run allows;
    /// returns the place reached.
    ///
    /// # Errors
    /// As [`step`](Self::step); the twins are as asked for even where that was cancelled.
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

    /// The session's run was taken elsewhere.
    pub(super) fn leave_twins(&mut self) {
        if let Some(twins) = &mut self.twins {
            twins.is_in_step = false;
        }
    }
}
