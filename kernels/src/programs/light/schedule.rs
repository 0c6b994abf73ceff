//! Which kernels run, in what order and until which condition holds.

use super::{illuminating, of as here, of_shadow_rays};
use crate::options::features::Features;
use crate::options::{Options, RaySource};
use crate::program::Kernel;
use crate::program::schedule::{Schedule, Step};
use crate::programs::closest_hit::kernels::{ACCUMULATE, GENERATE};
use crate::programs::closest_hit::schedule as of_rays;

/// The schedule for a run with these options: the rays, then a shadow ray to a light of each, until no ray has a light left.
pub(in crate::programs) fn of(options: &Options, features: &Features) -> Schedule {
    if !features.shadows {
        return Schedule { steps: mapped(&of_rays::of(options, features).steps, here) };
    }
    let given = matches!(options.rays, RaySource::Given(_));
    let rays = of_rays::new(options.schedule, features.structure(), given, false, false, features.many_steps).steps;
    let is_first = |step: &&Step| **step == Step::Run(GENERATE);
    let walk: Vec<Step> = rays.iter().filter(|step| !is_first(step)).cloned().collect();

    let mut steps = mapped(&rays, here);
    let mut light = mapped(&walk, of_shadow_rays);
    let starts = light.iter().find_map(|step| if let Step::Run(kernel) = step { Some(*kernel) } else { None });
    steps.push(Step::Run(illuminating()));
    light.push(Step::Run(illuminating()));
    steps.push(Step::LoopWhileActive(starts.into_iter().collect(), light));
    let mut steps = of_rays::until_idle(steps, features);
    if features.samples {
        steps.push(Step::Run(here(ACCUMULATE)));
        steps = vec![Step::LoopWhileActive(vec![here(GENERATE)], steps)];
    }
    Schedule { steps }
}

/// The same steps with other kernels.
fn mapped(steps: &[Step], to: fn(Kernel) -> Kernel) -> Vec<Step> {
    let step = |step: &Step| match step {
        Step::Run(kernel) => Step::Run(to(*kernel)),
        Step::RunBy(kernel, parameter) => Step::RunBy(to(*kernel), *parameter),
        Step::RunUntilIdle(kernel) => Step::RunUntilIdle(to(*kernel)),
        Step::LoopWhileActive(kernels, body) => {
            Step::LoopWhileActive(kernels.iter().map(|&kernel| to(kernel)).collect(), mapped(body, to))
        }
        Step::RepeatWhileAny(set, body) => Step::RepeatWhileAny(set, mapped(body, to)),
        Step::Repeat(name, times, body) => Step::Repeat(name, *times, mapped(body, to)),
    };
    steps.iter().map(step).collect()
}
