//! Reasons why a run does without a kernel, a stream or a buffer.

use super::features::{Features, StructureKind};
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

/// One kernel takes a ray several steps, but not in the fused kernel.
pub const WALKED: Reason = (Because::Options, "needed only with --schedule compact and --steps-per-pass 2 or more");
/// Nothing takes a ray several steps.
pub const SEVERAL_STEPS: Reason = (
    Because::Options,
    "needed only with several steps per pass: --schedule fused, or compact with --steps-per-pass 2 or more",
);
/// Nothing is shaded.
pub const NO_SHADE: Reason = (Because::View, "the result is hits, not an image");
/// There is one sample per pixel, so nothing is averaged.
pub const ONE_SAMPLE: Reason = (Because::Options, "needed only with --spp 2 or more");
/// Rays are given by the caller.
pub const GIVEN: Reason = (Because::View, "input rays");
/// Rays are generated in the kernel that traces them.
pub const EYE_RAYS: Reason = (
    Because::Options,
    "the fused kernel generates its rays: needed only for an image, or --schedule first, second or compact",
);

/// Whole paths are followed in one kernel.
const WHOLE_PATHS: Reason = (
    Because::Options,
    "another kernel follows whole paths: needed only if that binds more storage buffers, or takes more loop turns, than the device allows",
);

/// The acceleration structures that something belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum On {
    /// Any, or none.
    Any,
    /// A uniform grid.
    Grid,
    /// An irregular grid, or a grid of two levels.
    Irregular,
    /// Either.
    Cells,
    /// A BVH.
    Bvh,
}

/// The passes that something belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passes {
    /// All.
    Any,
    /// Of several kernels, in which rays take one step or more.
    Stepped,
    /// In which rays take one step.
    OneStep,
    /// Of one kernel, in which rays take all steps.
    Fused,
}

/// The options that are missing, for an acceleration structure and with each of [`Passes`].
macro_rules! needed_only_with {
    ($accelerator:literal, $and:literal) => {
        [
            concat!("needed only with ", $accelerator),
            concat!("needed only with ", $accelerator, $and, "--schedule first, second or compact"),
            concat!(
                "needed only with ",
                $accelerator,
                $and,
                "one step per pass: --schedule first or second, or compact with --steps-per-pass 1"
            ),
            concat!("needed only with ", $accelerator, $and, "--schedule fused"),
        ]
    };
}

impl Run<'_> {
    /// Whether one kernel traces rays from start to hit.
    #[must_use]
    pub fn is_fused(&self) -> bool {
        self.options.schedule == ScheduleKind::Fused
    }

    /// What would need something that belongs to these acceleration structures and passes.
    #[must_use]
    pub fn needed_only(&self, on: On, passes: Passes) -> Reason {
        let (structure, many_steps) = (self.features.structure(), self.features.many_steps);
        let has_accelerator = match on {
            On::Any => true,
            On::Grid => structure == StructureKind::Grid,
            On::Irregular => structure == StructureKind::Irregular,
            On::Cells => structure.has_cells(),
            On::Bvh => structure == StructureKind::Bvh,
        };
        let has_passes = match passes {
            Passes::Any => true,
            Passes::Stepped => !self.is_fused(),
            Passes::OneStep => !self.is_fused() && !many_steps,
            Passes::Fused => self.is_fused(),
        };
        if !has_accelerator && let Some(reason) = self.chosen_by_scene() {
            return (Because::Scene, reason);
        }
        let with = match on {
            _ if has_accelerator => needed_only_with!("", ""),
            On::Any => needed_only_with!("", ""),
            On::Grid => needed_only_with!("--accelerator grid", " and "),
            On::Irregular => needed_only_with!("--accelerator irregular", " and "),
            On::Cells => needed_only_with!("--accelerator grid or irregular", " and "),
            On::Bvh => needed_only_with!("--accelerator bvh", " and "),
        };
        if self.features.path && passes == Passes::Fused && has_accelerator {
            return WHOLE_PATHS;
        }
        let missing = if has_passes { Passes::Any } else { passes };
        (Because::Options, with[missing as usize])
    }

    /// Why the scene decided the acceleration structure, if it did.
    fn chosen_by_scene(&self) -> Option<&'static str> {
        let is_auto = self.options.accelerator == Accelerator::Auto;
        match self.accelerator {
            Accelerator::Grid if self.features.irregular => Some("crowded cells of the grid are divided further"),
            Accelerator::Grid if is_auto => Some("--accelerator auto chose grid"),
            Accelerator::Bvh if is_auto => Some("--accelerator auto chose bvh"),
            Accelerator::None if is_auto => Some("--accelerator auto chose none"),
            _ => None,
        }
    }

    /// The given reason if the run shades, else that nothing is shaded.
    #[must_use]
    pub fn of_shading(&self, reason: &'static str) -> Reason {
        if self.options.shade { (Because::Scene, reason) } else { NO_SHADE }
    }
}
