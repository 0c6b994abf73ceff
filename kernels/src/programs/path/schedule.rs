//! Which kernels run, in what order and until which condition holds.

use super::{of as here, own};
use crate::options::features::Features;
use crate::options::{Options, RaySource};
use crate::program::schedule::{Schedule, Step};
use crate::programs::closest_hit::kernels::{ACCUMULATE, GENERATE};
use crate::programs::closest_hit::schedule as of_rays;
use crate::programs::light::{mapped, shadow_kernel, while_begun};

/// The schedule for a run with these options: rays are traced, a shadow ray from the hit of each, and the next rays from there,
/// until no path goes on.
pub(in crate::programs) fn of(options: &Options, features: &Features) -> Schedule {
    if !features.path {
        return Schedule { steps: mapped(&of_rays::of(options, features).steps, &here) };
    }
    let given = matches!(options.rays, RaySource::Given(_));
    let rays = of_rays::new(options.schedule, features.structure(), given, false, false, features.many_steps).steps;
    let is_first = |step: &&Step| **step == Step::Run(GENERATE);
    let walk: Vec<Step> = rays.iter().filter(|step| !is_first(step)).cloned().collect();

    let mut bounce = mapped(&walk, &here);
    bounce.push(Step::Run(own(0)));
    if features.shadows {
        bounce.push(while_begun(mapped(&walk, &|kernel| shadow_kernel(&super::PROGRAM, kernel))));
    }
    bounce.push(Step::Run(own(1)));
    let mut steps = mapped(&rays, &here);
    steps.truncate(rays.len() - walk.len());
    steps.push(while_begun(bounce));
    let mut steps = of_rays::until_idle(steps, features);
    if features.samples {
        steps.push(Step::Run(here(ACCUMULATE)));
        steps = vec![Step::LoopWhileActive(vec![here(GENERATE)], steps)];
    }
    Schedule { steps }
}
