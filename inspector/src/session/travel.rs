//! Moves a run between places, through passes, checkpoints and edits.

use std::ops::ControlFlow;

use raystep_kernels::{Progress, RenderError};

use super::{OnProgress, Session};
use crate::settings::traces_rays;

/// Reports progress, and may stop the run.
pub(super) struct Guide<'a> {
    progress: &'a mut OnProgress<'a>,
    is_halted: bool,
}

impl<'a> Guide<'a> {
    pub(super) fn new(progress: &'a mut OnProgress<'_>) -> Self {
        Self { progress, is_halted: false }
    }

    fn tell(&mut self, progress: &Progress) -> ControlFlow<()> {
        let answer = (self.progress)(progress);
        self.is_halted |= answer.is_break();
        answer
    }

    /// Whether to continue.
    ///
    /// # Errors
    /// After a halt, with the place reached.
    pub(super) fn check(&self, place: usize) -> Result<(), RenderError> {
        if self.is_halted { Err(RenderError::Cancelled { passes: place }) } else { Ok(()) }
    }
}

impl Session {
    /// Goes to a place, or to the end where that comes first.
    pub(super) async fn go(&mut self, place: usize, guide: &mut Guide<'_>) -> Result<(), RenderError> {
        let result = self.travel(place, guide).await;
        // A stop takes effect between two legs, when the state is consistent.
        self.is_settled = matches!(result, Ok(()) | Err(RenderError::Cancelled { .. }));
        result
    }

    async fn travel(&mut self, place: usize, guide: &mut Guide<'_>) -> Result<(), RenderError> {
        // A lost device leaves the session where it was, so that the place to resume at is still known.
        self.renderer.health()?;
        let is_here = self.is_settled && !self.renderer.is_ahead() && self.place() <= place;
        self.is_settled = false;
        let nearest = self.history.nearest(place).filter(|kept| !is_here || kept.place() > self.place());
        if let Some(checkpoint) = nearest {
            self.renderer.restore(checkpoint)?;
            self.leave_twins();
        } else if !is_here {
            self.renderer.restart();
            self.leave_twins();
            self.apply_edits().await?;
        }
        while self.place() < place && self.renderer.next_kernel().is_some() {
            self.leg(place, guide).await?;
            if self.place() < place {
                guide.check(self.place())?;
            }
        }
        Ok(())
    }

    /// Up to the next action between two passes.
    async fn leg(&mut self, place: usize, guide: &mut Guide<'_>) -> Result<(), RenderError> {
        let here = self.place();
        let mut stop = place.min(here.saturating_add(self.history.passes_to_checkpoint(here)));
        if let Some(edit) = self.edits.iter().find(|e| e.place > here) {
            stop = stop.min(edit.place);
        }
        let known = self.history.known().len();
        if let Some(sketcher) = &self.sketcher {
            // Only passes that run for the first time.
            stop = stop.min(sketcher.after(here.max(known)));
        }
        let result = match self.run_to(stop, guide).await {
            Err(RenderError::Cancelled { .. }) if !guide.is_halted => Ok(()),
            result => result,
        };
        self.history.note(self.renderer.passes());
        if self.place() == stop {
            self.apply_edits().await?;
        }
        result?;
        let is_last = self.is_before_end();
        if self.history.is_due(self.place(), is_last) {
            let checkpoint = self.renderer.checkpoint().await;
            self.history.keep(checkpoint)?;
        }
        if self.place() > known
            && let Some(sketcher) = &mut self.sketcher
        {
            sketcher.take(&self.renderer).await?;
        }
        Ok(())
    }

    /// Runs passes: first on the CPU reference, as many as are assigned to it, then on the session's device.
    async fn run_to(&mut self, stop: usize, guide: &mut Guide<'_>) -> Result<(), RenderError> {
        let here = self.place();
        // A pause where the walks have ended: the place before the last passes is worth a checkpoint.
        let mut tell = |progress: &Progress| match guide.tell(progress) {
            ControlFlow::Continue(()) if is_decided(progress) => ControlFlow::Break(()),
            answer => answer,
        };
        match &mut self.twins {
            Some(twins) if here < twins.until => twins.run_to(&mut self.renderer, stop, &mut tell).await,
            _ => self.renderer.run_to(stop, tell).await,
        }
    }

    /// Whether all hits are known and only the last passes are missing.
    fn is_before_end(&self) -> bool {
        traces_rays(self.renderer.plan().program)
            && self.renderer.next_kernel().is_some()
            && is_decided(&self.renderer.progress())
    }

    /// Applies the edits of this place.
    async fn apply_edits(&mut self) -> Result<(), RenderError> {
        let here = self.place();
        for edit in self.edits.iter().filter(|e| e.place == here) {
            self.renderer.write_component(edit.stream, edit.layer, edit.x, edit.y, edit.bits).await?;
        }
        if self.edits.iter().any(|e| e.place == here) {
            self.leave_twins();
        }
        Ok(())
    }
}

/// Whether all hits of the last sample are known.
fn is_decided(progress: &Progress) -> bool {
    progress.rays_decided == progress.rays && progress.samples.saturating_add(1) >= progress.samples_wanted
}
