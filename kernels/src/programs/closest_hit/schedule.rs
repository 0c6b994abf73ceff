//! Which kernels run, in what order and until which condition holds.

use super::kernels::{
    ACCUMULATE, DECIDE, FUSED, GENERATE, INTERSECT, SETUP, SHADE, TRAVERSE_BVH, TRAVERSE_GRID, TRAVERSE_IRREGULAR, WALK,
};
use crate::options::features::{Features, StructureKind};
use crate::options::{Options, RaySource, ScheduleKind};
use crate::program::Kernel;
use crate::program::schedule::{Schedule, Step};

/// The paper's schedules (§4.3), and ours. `rays_given`: rays are not generated; `shade`: the image is wanted.
#[must_use]
pub fn new(kind: ScheduleKind, features: &Features, rays_given: bool, shade: bool) -> Schedule {
    let Features { eye_rays, many_steps, exact_order, .. } = *features;
    let mut steps = Vec::new();
    if !rays_given && !eye_rays {
        steps.push(Step::Run(GENERATE));
    }
    if kind == ScheduleKind::Fused {
        steps.push(Step::Run(FUSED));
    } else {
        let is_first = kind == ScheduleKind::First;
        let walk = match features.structure() {
            _ if many_steps => Step::RunUntilIdle(WALK),
            StructureKind::None => Step::RunUntilIdle(INTERSECT),
            StructureKind::Grid => steps_and_tests(TRAVERSE_GRID, is_first),
            StructureKind::Irregular => steps_and_tests(TRAVERSE_IRREGULAR, is_first),
            StructureKind::Bvh => steps_and_tests(TRAVERSE_BVH, is_first),
        };
        steps.extend([Step::Run(SETUP), walk]);
    }
    if exact_order {
        steps.push(Step::RunUntilIdle(DECIDE));
    }
    if shade {
        steps.push(Step::Run(SHADE));
    }
    Schedule { steps }
}

/// The walk in turns of steps and tests. `is_first`: all lists are tested to their ends before the next step.
fn steps_and_tests(traverse: Kernel, is_first: bool) -> Step {
    // The printed condition of the first strategy is inverted; `while (!done || traverser())` is meant.
    let test = if is_first { Step::RunUntilIdle(INTERSECT) } else { Step::Run(INTERSECT) };
    let mut body = vec![test, Step::Run(traverse)];
    // A BVH's root has no triangles, so its walk begins with a step.
    if traverse == TRAVERSE_BVH {
        body.reverse();
    }
    Step::LoopWhileActive(vec![INTERSECT, traverse], body)
}

/// The schedule for a run with these options.
#[must_use]
pub fn of(options: &Options, features: &Features) -> Schedule {
    let given = matches!(options.rays, RaySource::Given(_));
    let mut schedule = new(options.schedule, features, given, options.shade);
    schedule.steps = until_idle(schedule.steps, features);
    if features.samples { for_samples(schedule) } else { schedule }
}

/// The same, where kernels run again that leave rays for another dispatch; a walk's own loop runs its kernels again anyway.
pub(in crate::programs) fn until_idle(steps: Vec<Step>, features: &Features) -> Vec<Step> {
    let step = |step| match step {
        Step::Run(kernel) if (kernel.info().resumes)(&kernel.features(features)) => Step::RunUntilIdle(kernel),
        Step::LoopWhileActive(kernels, body) if !kernels.iter().any(|kernel| kernel.is_walk()) => {
            Step::LoopWhileActive(kernels, until_idle(body, features))
        }
        step => step,
    };
    steps.into_iter().map(step).collect()
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
