//! Which kernels run, in what order and until which condition holds.

use super::kernels::{
    ACCUMULATE, FUSED, GENERATE, INTERSECT, SETUP, SHADE, TRAVERSE_BVH, TRAVERSE_GRID, TRAVERSE_IRREGULAR, WALK,
};
use crate::options::features::Features;
use crate::options::{Accelerator, Options, RaySource, ScheduleKind};
use crate::program::schedule::{Schedule, Step};

/// The paper's schedules (§4.3), and ours. `rays_given`: rays are not generated; `shade`: the image is wanted;
/// `eye_rays`: the fused kernel generates its rays; `many_steps`: a ray takes several steps per pass.
#[must_use]
pub fn new(
    kind: ScheduleKind,
    accelerator: Accelerator,
    rays_given: bool,
    shade: bool,
    eye_rays: bool,
    many_steps: bool,
) -> Schedule {
    let mut steps = Vec::new();
    if !rays_given && !eye_rays {
        steps.push(Step::Run(GENERATE));
    }
    if kind == ScheduleKind::Fused {
        steps.push(Step::Run(FUSED));
    } else {
        let is_first = kind == ScheduleKind::First;
        let walk = match accelerator {
            _ if many_steps => Step::RunUntilIdle(WALK),
            // The printed condition of the first strategy is inverted; `while (!done || traverser())` is meant.
            Accelerator::Grid | Accelerator::Auto if is_first => Step::LoopWhileActive(
                vec![INTERSECT, TRAVERSE_GRID],
                vec![Step::RunUntilIdle(INTERSECT), Step::Run(TRAVERSE_GRID)],
            ),
            Accelerator::Grid | Accelerator::Auto => Step::LoopWhileActive(
                vec![INTERSECT, TRAVERSE_GRID],
                vec![Step::Run(INTERSECT), Step::Run(TRAVERSE_GRID)],
            ),
            Accelerator::Irregular if is_first => Step::LoopWhileActive(
                vec![INTERSECT, TRAVERSE_IRREGULAR],
                vec![Step::RunUntilIdle(INTERSECT), Step::Run(TRAVERSE_IRREGULAR)],
            ),
            Accelerator::Irregular => Step::LoopWhileActive(
                vec![INTERSECT, TRAVERSE_IRREGULAR],
                vec![Step::Run(INTERSECT), Step::Run(TRAVERSE_IRREGULAR)],
            ),
            // A BVH's root has no triangles, so its walk begins with a step.
            Accelerator::Bvh if is_first => Step::LoopWhileActive(
                vec![INTERSECT, TRAVERSE_BVH],
                vec![Step::Run(TRAVERSE_BVH), Step::RunUntilIdle(INTERSECT)],
            ),
            Accelerator::Bvh => Step::LoopWhileActive(
                vec![INTERSECT, TRAVERSE_BVH],
                vec![Step::Run(TRAVERSE_BVH), Step::Run(INTERSECT)],
            ),
            Accelerator::None => Step::RunUntilIdle(INTERSECT),
        };
        steps.extend([Step::Run(SETUP), walk]);
    }
    if shade {
        steps.push(Step::Run(SHADE));
    }
    Schedule { steps }
}

/// The schedule for a run with these options; `accelerator` is never [`Accelerator::Auto`].
#[must_use]
pub fn of(options: &Options, accelerator: Accelerator, features: &Features) -> Schedule {
    let given = matches!(options.rays, RaySource::Given(_));
    let Features { eye_rays, many_steps, samples, .. } = *features;
    // A grid of two levels is walked as an irregular one.
    let accelerator = if features.irregular { Accelerator::Irregular } else { accelerator };
    let mut schedule = new(options.schedule, accelerator, given, options.shade, eye_rays, many_steps);
    for step in &mut schedule.steps {
        if let Step::Run(kernel) = *step
            && (kernel.info().resumes)(features)
        {
            *step = Step::RunUntilIdle(kernel);
        }
    }
    if samples { for_samples(schedule) } else { schedule }
}

/// The same for several samples per pixel: repeats all steps as long as a pixel asks for another sample.
#[must_use]
pub fn for_samples(schedule: Schedule) -> Schedule {
    let mut body = schedule.steps;
    body.push(Step::Run(ACCUMULATE));
    Schedule { steps: vec![Step::LoopWhileActive(vec![GENERATE], body)] }
}

#[cfg(test)]
mod tests;
