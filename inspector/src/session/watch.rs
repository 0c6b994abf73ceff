//! Conditions at which a run stops.

mod look;

use raystep_kernels::RenderError;
use raystep_lab::text::counted;
use serde::{Deserialize, Serialize};

use super::travel::Guide;
use super::{OnProgress, Session};
use look::Look;

/// A condition to stop at. It fires after the pass in which it becomes true, and not again while it stays true; an edit
/// right after a pass counts as part of that pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Watch {
    /// A float of any ray, in any stream, becomes infinite or not a number. No layer may hold such a value: t without
    /// a hit, and `tmax` along an axis that is never crossed, are [`INF`](raystep_kernels::shared::constants::INF),
    /// which is a finite number.
    NonFinite,
    /// `tmax` of any active ray decreases along any axis: the walk goes backwards.
    TMaxBackwards,
    /// Any ray visits more cells, or nodes, than this.
    MoreSteps(u32),
    /// The selected ray's state changes; in a program without states, any value of the selected element.
    RayState,
    /// The selected ray's hit changes: its triangle, or t.
    RayHit,
    /// The selected ray goes to another cell or node.
    RayCell,
}

impl Watch {
    /// One of each kind.
    pub const ALL: [Self; 6] =
        [Self::NonFinite, Self::TMaxBackwards, Self::MoreSteps(64), Self::RayState, Self::RayHit, Self::RayCell];

    /// The displayed name.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::NonFinite => "any ray: value that is not finite".into(),
            Self::TMaxBackwards => "any ray: tmax decreases".into(),
            Self::MoreSteps(steps) => format!("any ray: more than {}", counted(steps, "step")),
            Self::RayState => "selected ray: its state changes".into(),
            Self::RayHit => "selected ray: its hit changes".into(),
            Self::RayCell => "selected ray: its cell changes".into(),
        }
    }

    /// Whether it concerns the selected ray only, which is much faster.
    #[must_use]
    pub fn is_of_ray(self) -> bool {
        matches!(self, Self::RayState | Self::RayHit | Self::RayCell)
    }
}

/// The direction to run in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To the next place at which a watch fires.
    Forward,
    /// To the last place before this one at which a watch fired.
    Back,
}

/// A watch that fired.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fired {
    /// Which.
    pub watch: Watch,
    /// Passes so far.
    pub place: usize,
    /// Pixel of the ray; of the first one in reading order where there are more.
    pub ray: [u32; 2],
    /// How many rays it fired for.
    pub rays: u32,
    /// Description with values.
    pub value: String,
}

impl Session {
    /// Runs to a place at which one of the watches fires: if several do, the first in the list. `None` if none does:
    /// the session is then after the last pass, or before the first.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`] with the place reached where `progress` stopped it. Else where the device fails.
    pub async fn run_to_watch(
        &mut self,
        watches: &[Watch],
        direction: Direction,
        progress: &mut OnProgress<'_>,
    ) -> Result<Option<Fired>, RenderError> {
        let mut guide = Guide::new(progress);
        if watches.is_empty() {
            return Ok(None);
        }
        let here = self.place();
        if direction == Direction::Forward {
            return self.last_fired(watches, [here, usize::MAX], true, &mut guide).await;
        }
        // From checkpoint to checkpoint, the last first, to run as few passes as possible.
        let mut starts: Vec<usize> = match Look::needs_start(&self.renderer, watches) {
            true => Vec::new(),
            false => self.kept_places().filter(|&place| place > 0 && place + 1 < here).collect(),
        };
        starts.insert(0, 0);
        let mut end = here.saturating_sub(1);
        for start in starts.into_iter().rev() {
            if let Some(fired) = self.last_fired(watches, [start, end], false, &mut guide).await? {
                self.go(fired.place, &mut guide).await?;
                return Ok(Some(fired));
            }
            end = start;
        }
        self.go(0, &mut guide).await?;
        Ok(None)
    }

    /// What fires at places after `start` and not after `end`: the first if `is_first`, otherwise the last.
    async fn last_fired(
        &mut self,
        watches: &[Watch],
        [start, end]: [usize; 2],
        is_first: bool,
        guide: &mut Guide<'_>,
    ) -> Result<Option<Fired>, RenderError> {
        let begin = if Look::needs_start(&self.renderer, watches) { 0 } else { start };
        self.go(begin, guide).await?;
        let mut look = Look::new(&self.renderer, watches, self.pixel).await?;
        let mut last = None;
        while self.place() < end && self.renderer.next_kernel().is_some() {
            guide.check(self.place())?;
            self.go(self.place() + 1, guide).await?;
            let place = self.place();
            let edited = self.edits.iter().filter(|e| e.place == place).map(|e| e.stream).collect::<Vec<_>>();
            let fired = look.after_pass(&self.renderer, &edited).await?;
            if place > start && fired.is_some() {
                last = fired;
                if is_first {
                    break;
                }
            }
        }
        Ok(last)
    }
}
