//! Whether the rays of a session's run can be judged.

use raystep_kernels::Plan;

use super::Edit;

/// Why they cannot be, in a line; `None` where they can.
#[must_use]
pub fn why_not(plan: &Plan, edits: &[Edit], twins: Option<usize>) -> Option<&'static str> {
    if !edits.is_empty() {
        Some("not judged: the run was changed by hand, and is judged once the changes are taken back")
    } else if twins.is_some() {
        Some("not judged: the first passes are the twins', and what is judged is a run of the device alone")
    } else {
        raystep_lab::judge::why_not(plan)
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::streams;
    use raystep_kernels::{Limits, Options, RaySource};
    use raystep_scenes::generate;

    use super::*;

    #[test]
    fn a_run_that_is_not_the_devices_alone_is_not_judged() {
        let scene = generate::cornell_box();
        let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 16, height: 16 };
        let (plan, _) = Plan::new(&scene, &Options::new(rays), &Limits::CPU).expect("a plan");
        assert_eq!(why_not(&plan, &[], None), None);
        let edit = Edit { place: 3, stream: streams::HIT, layer: 0, x: 1, y: 1, bits: 0 };
        assert!(why_not(&plan, &[edit], None).is_some_and(|why| why.contains("by hand")));
        assert!(why_not(&plan, &[], Some(3)).is_some_and(|why| why.contains("twins")));
    }
}
