//! Which kernels run, in what order and until which condition holds.

use super::{Own, of as here, own};
use crate::options::features::Features;
use crate::options::{Options, RaySource};
use crate::program::Kernel;
use crate::program::schedule::{Schedule, Step};
use crate::programs::closest_hit::kernels::{ACCUMULATE, GENERATE};
use crate::programs::closest_hit::schedule as of_rays;
use crate::programs::light::{mapped, shadow_kernel, while_begun};

/// The schedule for a run with these options: rays are traced, a shadow ray from the hit of each, and the next rays from there,
/// until no path goes on; or all of that in one kernel.
pub(in crate::programs) fn of(options: &Options, features: &Features) -> Schedule {
    if !features.path {
        return Schedule { steps: mapped(&of_rays::of(options, features).steps, &here) };
    }
    if features.whole_paths {
        let mut steps = vec![Step::Run(own(Own::FusedPath))];
        if !matches!(options.rays, RaySource::Given(_)) {
            steps.insert(0, Step::Run(here(GENERATE)));
        }
        return Schedule { steps: sampled(steps, features, &here) };
    }
    let given = matches!(options.rays, RaySource::Given(_));
    let rays = of_rays::new(options.schedule, features, given, false).steps;
    let is_first = |step: &&Step| **step == Step::Run(GENERATE);
    let walk: Vec<Step> = rays.iter().filter(|step| !is_first(step)).cloned().collect();

    let mut bounce = mapped(&walk, &here);
    bounce.push(Step::Run(own(Own::SampleLight)));
    if features.shadows {
        bounce.push(while_begun(mapped(&walk, &|kernel| shadow_kernel(&super::PROGRAM, kernel))));
    }
    bounce.push(Step::Run(own(Own::SampleBsdf)));
    let mut steps = mapped(&rays, &here);
    steps.truncate(rays.len() - walk.len());
    steps.push(while_begun(bounce));
    Schedule { steps: sampled(of_rays::until_idle(steps, features), features, &here) }
}

/// The same for every sample, by the kernels of a program.
pub(in crate::programs) fn sampled(
    mut steps: Vec<Step>,
    features: &Features,
    here: &impl Fn(Kernel) -> Kernel,
) -> Vec<Step> {
    if !features.samples {
        return steps;
    }
    steps.push(Step::Run(here(ACCUMULATE)));
    vec![Step::LoopWhileActive(vec![here(GENERATE)], steps)]
}
