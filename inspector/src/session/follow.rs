//! The whole history of one ray, from the session's own passes: including edits and the CPU reference.

use raystep_kernels::RenderError;
use raystep_kernels::export::trace::{Trace, TraceRow, ray_state};

use super::travel::Guide;
use super::{OnProgress, Session, go_on};
use crate::settings::traces_rays;

impl Session {
    /// Follows one ray from the first pass to the last, then returns to the current place. An edit right after a pass
    /// counts as part of it.
    ///
    /// # Errors
    /// Where the image has no such pixel; [`RenderError::Cancelled`] where `progress` stopped it, after coming back; else
    /// where the device fails.
    pub async fn follow(&mut self, x: u32, y: u32, progress: &mut OnProgress<'_>) -> Result<Trace, RenderError> {
        let mut guide = Guide::new(progress);
        let here = self.place();
        if !traces_rays(self.renderer.plan().program) {
            return Ok(Trace::new(&self.renderer, [x, y], Vec::new()));
        }
        ray_state(&self.renderer, x, y).await?;
        let followed = self.follow_from_start([x, y], &mut guide).await;
        // Return even if it was stopped: following must not move the user's view.
        if matches!(followed, Ok(_) | Err(RenderError::Cancelled { .. })) {
            self.go(here, &mut Guide::new(&mut go_on)).await?;
        }
        followed
    }

    async fn follow_from_start(&mut self, [x, y]: [u32; 2], guide: &mut Guide<'_>) -> Result<Trace, RenderError> {
        self.go(0, guide).await?;
        let mut before = ray_state(&self.renderer, x, y).await?;
        let mut rows = Vec::new();
        while self.renderer.next_kernel().is_some() {
            guide.check(self.place())?;
            self.go(self.place() + 1, guide).await?;
            let place = self.place();
            let Some(pass) = self.passes().last().cloned() else { break };
            let is_worked_on = pass.kernel.takes().contains(&before.tag);
            // A kernel ignores rays in other states: there is nothing to read back then.
            if is_worked_on || self.edits.iter().any(|e| (e.place, e.x, e.y) == (place, x, y)) {
                let after = ray_state(&self.renderer, x, y).await?;
                if is_worked_on {
                    rows.push(TraceRow::new(&pass, self.renderer.data(), &before, &after));
                }
                before = after;
            }
        }
        Ok(Trace::new(&self.renderer, [x, y], rows))
    }
}
