//! Which kernels run, in what order and until which condition holds.

use super::{PROGRAM, illuminating, of as here, scattering, shadow_kernel};
use crate::options::features::Features;
use crate::options::{Options, RaySource};
use crate::program::Kernel;
use crate::program::schedule::{Schedule, Step};
use crate::programs::closest_hit::kernels::{ACCUMULATE, GENERATE};
use crate::programs::closest_hit::schedule as of_rays;

/// The schedule for a run with these options: the rays, then a shadow ray to a light of each, until no ray has a light left;
/// and the same for the rays that go on from there, until none does.
pub(in crate::programs) fn of(options: &Options, features: &Features) -> Schedule {
    if !features.shadows {
        return Schedule { steps: mapped(&of_rays::of(options, features).steps, &here) };
    }
    let given = matches!(options.rays, RaySource::Given(_));
    let rays = of_rays::new(options.schedule, features, given, false).steps;
    let is_first = |step: &&Step| **step == Step::Run(GENERATE);
    let walk: Vec<Step> = rays.iter().filter(|step| !is_first(step)).cloned().collect();

    let mut light = mapped(&walk, &|kernel| shadow_kernel(&PROGRAM, kernel));
    light.push(Step::Run(illuminating()));
    let light = [Step::Run(illuminating()), while_begun(light)];
    let mut steps = mapped(&rays, &here);
    if features.specular {
        steps.truncate(rays.len() - walk.len());
        let mut bounce = mapped(&walk, &here);
        bounce.extend(light);
        bounce.push(Step::Run(scattering()));
        steps.push(while_begun(bounce));
    } else {
        steps.extend(light);
    }
    let mut steps = of_rays::until_idle(steps, features);
    if features.samples {
        steps.push(Step::Run(here(ACCUMULATE)));
        steps = vec![Step::LoopWhileActive(vec![here(GENERATE)], steps)];
    }
    Schedule { steps }
}

/// These steps, as long as there are rays for the first kernel among them.
pub(in crate::programs) fn while_begun(steps: Vec<Step>) -> Step {
    let first = steps.iter().find_map(|step| if let Step::Run(kernel) = step { Some(*kernel) } else { None });
    Step::LoopWhileActive(first.into_iter().collect(), steps)
}

/// The same steps with other kernels.
pub(in crate::programs) fn mapped(steps: &[Step], to: &dyn Fn(Kernel) -> Kernel) -> Vec<Step> {
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
