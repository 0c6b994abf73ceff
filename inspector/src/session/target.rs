//! Targets of steps.

use raystep_kernels::{Kernel, Pass, RenderError};

use super::travel::Guide;
use super::{OnProgress, Session};

/// The target of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// One pass forwards.
    Next,
    /// One pass backwards.
    Previous,
    /// After the next pass of a kernel.
    NextOf(Kernel),
    /// After the previous pass of a kernel.
    PreviousOf(Kernel),
    /// Before the first pass of the turn that the last pass belongs to: of the innermost loop whose turns may have several
    /// passes. Passes before a loop, and those after it, count as one turn.
    IterationStart,
    /// After the last pass of the turn that the next pass belongs to.
    IterationEnd,
    /// After this many passes in total.
    Pass(usize),
    /// Before the first pass.
    Start,
    /// After the last pass.
    End,
}

/// The turns that a pass belongs to, and whether it is part of the walk.
type Turn = (Vec<u32>, bool);

impl Session {
    fn turn(&self, kernel: Kernel, loops: &[u32]) -> Turn {
        (self.renderer.plan().schedule.turns_of_several_passes(kernel, loops).to_vec(), kernel.is_walk())
    }

    fn turn_of(&self, pass: &Pass) -> Turn {
        self.turn(pass.kernel, &pass.loops)
    }

    fn next_turn(&self) -> Option<Turn> {
        self.renderer.next_pass().map(|(kernel, loops)| self.turn(kernel, &loops))
    }

    /// Goes to `target`, or as near as the run allows; returns the place reached.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`] with the place reached where `progress` stopped it: streams and passes are those of
    /// that place, and the session can go on from there. Else where the device fails.
    pub async fn step(&mut self, target: Target, progress: &mut OnProgress<'_>) -> Result<usize, RenderError> {
        let mut guide = Guide::new(progress);
        let here = self.place();
        match target {
            Target::Next => self.go(here + 1, &mut guide).await?,
            Target::Previous => self.go(here.saturating_sub(1), &mut guide).await?,
            Target::Pass(place) => self.go(place, &mut guide).await?,
            Target::Start => self.go(0, &mut guide).await?,
            Target::End => self.go(usize::MAX, &mut guide).await?,
            Target::NextOf(kernel) => self.go_to_next(kernel, &mut guide).await?,
            Target::IterationEnd => self.go_to_end_of_turn(&mut guide).await?,
            Target::PreviousOf(kernel) => {
                let earlier = &self.passes()[..here.saturating_sub(1)];
                let place = earlier.iter().rposition(|p| p.kernel == kernel).map_or(0, |i| i + 1);
                self.go(place, &mut guide).await?;
            }
            Target::IterationStart => {
                let passes = self.passes();
                let Some(this) = passes.last().map(|p| self.turn_of(p)) else { return Ok(here) };
                let place = passes.iter().rposition(|p| self.turn_of(p) != this).map_or(0, |i| i + 1);
                self.go(place, &mut guide).await?;
            }
        }
        Ok(self.place())
    }

    async fn go_to_next(&mut self, kernel: Kernel, guide: &mut Guide<'_>) -> Result<(), RenderError> {
        let here = self.place();
        if let Some(passes) = self.known()[here..].iter().position(|p| p.kernel == kernel) {
            return self.go(here + passes + 1, guide).await;
        }
        // Beyond the known passes, only running a pass can tell.
        self.go(self.known().len(), guide).await?;
        loop {
            let before = self.place();
            self.go(before + 1, guide).await?;
            if self.place() == before || self.passes().last().is_some_and(|p| p.kernel == kernel) {
                return Ok(());
            }
            guide.check(self.place())?;
        }
    }

    async fn go_to_end_of_turn(&mut self, guide: &mut Guide<'_>) -> Result<(), RenderError> {
        let here = self.place();
        let Some(this) = self.next_turn() else { return Ok(()) };
        if let Some(passes) = self.known()[here..].iter().position(|p| self.turn_of(p) != this) {
            return self.go(here + passes, guide).await;
        }
        self.go(self.known().len(), guide).await?;
        while self.next_turn().as_ref() == Some(&this) {
            self.go(self.place() + 1, guide).await?;
            guide.check(self.place())?;
        }
        Ok(())
    }
}
