//! Why a run does without a kernel, a stream or a buffer.

use super::features::Features;
use super::{Accelerator, Options, ScheduleKind};

/// Who made it unnecessary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Because {
    /// The scene does not have it.
    Scene,
    /// The options do not ask for it.
    Options,
    /// The result that is wanted does not show it.
    View,
}

/// Where a reason lies, and the reason.
pub type Reason = (Because, &'static str);

/// A run that does without something.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// What was asked for.
    pub options: &'a Options,
    /// The options of the kernels.
    pub features: &'a Features,
    /// What keeps rays from testing every triangle; never [`Accelerator::Auto`].
    pub accelerator: Accelerator,
}

/// The schedule steps.
pub const STEPPED: Reason = (Because::Options, "the schedule steps");
/// The schedule does not step.
pub const FUSED: Reason = (Because::Options, "--schedule fused");
/// Steps and tests are one kernel.
pub const MANY_STEPS: Reason = (Because::Options, "several steps per pass are taken in one kernel");
/// A pass is one step.
pub const ONE_STEP: Reason = (Because::Options, "one step per pass");
/// Nothing is shaded.
pub const NO_SHADE: Reason = (Because::View, "the result is hits, not an image");
/// There is no mean of samples.
pub const ONE_SAMPLE: Reason = (Because::Options, "one sample per pixel");
/// Rays come from outside.
pub const GIVEN: Reason = (Because::View, "input rays");
/// Rays are made where they are traced.
pub const EYE_RAYS: Reason = (Because::Options, "the fused kernel generates its rays");

impl Run<'_> {
    /// Whether one kernel takes rays from their start to their hit.
    #[must_use]
    pub fn is_fused(&self) -> bool {
        self.options.schedule == ScheduleKind::Fused
    }

    /// Another accelerator was asked for, or chosen.
    #[must_use]
    pub fn other_accelerator(&self) -> Reason {
        match self.accelerator {
            Accelerator::Bvh if self.options.accelerator == Accelerator::Auto => {
                (Because::Scene, "--accelerator auto chose bvh")
            }
            Accelerator::None if self.options.accelerator == Accelerator::Auto => {
                (Because::Scene, "--accelerator auto chose none")
            }
            Accelerator::Bvh => (Because::Options, "--accelerator bvh"),
            Accelerator::None => (Because::Options, "--accelerator none"),
            Accelerator::Grid | Accelerator::Auto => (Because::Options, "--accelerator grid"),
        }
    }

    /// The scene has no need of it, if there is shading at all.
    #[must_use]
    pub fn of_shading(&self, reason: &'static str) -> Reason {
        if self.options.shade { (Because::Scene, reason) } else { NO_SHADE }
    }
}

/// Why a kernel that steps through a structure is left out.
#[must_use]
pub fn of_a_step(run: &Run<'_>) -> Reason {
    match run {
        Run { features, .. } if features.many_steps => MANY_STEPS,
        run if run.is_fused() => FUSED,
        run => run.other_accelerator(),
    }
}
