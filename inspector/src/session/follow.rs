//! The whole history of one ray, from the session's own passes: including edits and the CPU reference.

use raystep_kernels::export::trace::{Trace, TraceRow, state_of};
use raystep_kernels::program::Decoding;
use raystep_kernels::tables::elements::Elements;
use raystep_kernels::{Plan, RenderError};

use super::travel::Guide;
use super::{Edit, OnProgress, Session, go_on};
use crate::settings::traces_rays;

/// Whose history is told: a pixel's ray, or an element of another set that walks through the scene as rays do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subject {
    /// The set; `None` for rays.
    pub set: Option<&'static Elements>,
    /// Its texel: the pixel of a ray.
    pub texel: [u32; 2],
}

impl From<[u32; 2]> for Subject {
    fn from(texel: [u32; 2]) -> Self {
        Self { set: None, texel }
    }
}

impl Subject {
    /// How it is decoded in a run; `None` if that has no such elements.
    #[must_use]
    pub fn decoding(&self, plan: &Plan) -> Option<Decoding> {
        let of = match self.set {
            None => plan.program.rays,
            Some(set) => plan.program.decoding_of(set),
        };
        of.filter(|of| of.streams.first().is_some_and(|&stream| plan.has_stream(stream)))
    }
}

impl Session {
    /// Follows one ray or other element from the first pass to the last, then returns to the current place. An edit right after a pass
    /// counts as part of it.
    ///
    /// # Errors
    /// Where there is no such element; [`RenderError::Cancelled`] where `progress` stopped it, after coming back; else
    /// where the device fails.
    pub async fn follow(
        &mut self,
        subject: impl Into<Subject>,
        progress: &mut OnProgress<'_>,
    ) -> Result<Trace, RenderError> {
        let subject: Subject = subject.into();
        let mut guide = Guide::new(progress);
        let here = self.place();
        let plan = self.renderer.plan();
        if !traces_rays(plan.program) {
            return Ok(Trace::new(&self.renderer, subject.texel, Vec::new()));
        }
        let of = subject.decoding(plan).ok_or(RenderError::NoRays(plan.program.name))?;
        state_of(&self.renderer, &of, subject.texel).await?;
        let followed = self.follow_from_start(subject, &of, &mut guide).await;
        // Return even if it was stopped: following must not move the user's view.
        if matches!(followed, Ok(_) | Err(RenderError::Cancelled { .. })) {
            self.go(here, &mut Guide::new(&mut go_on)).await?;
        }
        followed
    }

    async fn follow_from_start(
        &mut self,
        Subject { set, texel }: Subject,
        of: &Decoding,
        guide: &mut Guide<'_>,
    ) -> Result<Trace, RenderError> {
        let [x, y] = texel;
        self.go(0, guide).await?;
        let mut before = state_of(&self.renderer, of, texel).await?;
        let mut rows = Vec::new();
        while self.renderer.next_kernel().is_some() {
            guide.check(self.place())?;
            self.go(self.place() + 1, guide).await?;
            let place = self.place();
            let Some(pass) = self.passes().last().cloned() else { break };
            let is_worked_on = pass.kernel.takes().contains(&before.tag);
            // A kernel ignores rays in other states: there is nothing to read back then.
            let is_edited = |e: &Edit| (e.place, e.x, e.y) == (place, x, y) && set.is_none();
            if is_worked_on || self.edits.iter().any(is_edited) {
                let after = state_of(&self.renderer, of, texel).await?;
                if is_worked_on {
                    rows.push(TraceRow::new(&pass, self.renderer.data(), &before, &after));
                }
                before = after;
            }
        }
        Ok(Trace::of(&self.renderer, of, texel, rows))
    }
}
