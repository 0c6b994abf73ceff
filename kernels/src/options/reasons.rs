//! Reasons why a run does without a kernel, a stream or a buffer.

use super::features::Features;
use super::{Accelerator, Options, ScheduleKind};
use crate::numbers::named::named;

/// What made it unnecessary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Because {
    /// The scene does not have it.
    Scene,
    /// The options do not ask for it.
    Options,
    /// The requested result does not show it.
    View,
}

named!(Because, "scene, options, view", Scene "scene", Options "options", View "view");

/// What made something unnecessary, and the reason in words.
pub type Reason = (Because, &'static str);

/// What a reason may depend on.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// The options as requested.
    pub options: &'a Options,
    /// The options of the kernels.
    pub features: &'a Features,
    /// The acceleration structure; never [`Accelerator::Auto`].
    pub accelerator: Accelerator,
}

/// The schedule moves rays in passes of steps.
pub const STEPPED: Reason = (Because::Options, "only for --schedule fused");
/// The schedule traces rays in one kernel, not in passes of steps.
pub const FUSED: Reason = (Because::Options, "--schedule fused");
/// One kernel both steps and tests.
pub const MANY_STEPS: Reason = (Because::Options, "several steps per pass are taken in one kernel");
/// A pass takes one step.
pub const ONE_STEP: Reason = (Because::Options, "one step per pass");
/// Nothing is shaded.
pub const NO_SHADE: Reason = (Because::View, "the result is hits, not an image");
/// There is one sample per pixel, so nothing is averaged.
pub const ONE_SAMPLE: Reason = (Because::Options, "one sample per pixel");
/// Rays are given by the caller.
pub const GIVEN: Reason = (Because::View, "input rays");
/// Rays are generated in the kernel that traces them.
pub const EYE_RAYS: Reason = (Because::Options, "the fused kernel generates its rays");

impl Run<'_> {
    /// Whether one kernel traces rays from start to hit.
    #[must_use]
    pub fn is_fused(&self) -> bool {
        self.options.schedule == ScheduleKind::Fused
    }

    /// The reason if another accelerator was requested or chosen.
    #[must_use]
    pub fn other_accelerator(&self) -> Reason {
        match self.accelerator {
            Accelerator::Bvh if self.options.accelerator == Accelerator::Auto => {
                (Because::Scene, "--accelerator auto chose bvh")
            }
            Accelerator::None if self.options.accelerator == Accelerator::Auto => {
                (Because::Scene, "--accelerator auto chose none")
            }
            Accelerator::Grid if self.features.irregular => {
                (Because::Scene, "crowded cells of the grid are divided further")
            }
            Accelerator::Bvh => (Because::Options, "--accelerator bvh"),
            Accelerator::Irregular => (Because::Options, "--accelerator irregular"),
            Accelerator::None => (Because::Options, "--accelerator none"),
            Accelerator::Grid | Accelerator::Auto => (Because::Options, "--accelerator grid"),
        }
    }

    /// The given reason if the run shades, else that nothing is shaded.
    #[must_use]
    pub fn of_shading(&self, reason: &'static str) -> Reason {
        if self.options.shade { (Because::Scene, reason) } else { NO_SHADE }
    }
}

/// Why a kernel that steps through an acceleration structure is left out.
#[must_use]
pub fn of_a_step(run: &Run<'_>) -> Reason {
    match run {
        Run { features, .. } if features.many_steps => MANY_STEPS,
        run if run.is_fused() => FUSED,
        run => run.other_accelerator(),
    }
}
