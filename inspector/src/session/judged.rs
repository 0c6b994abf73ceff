//! Whether a session's run can be judged.

use raystep_kernels::Plan;

use super::Edit;

/// Why it cannot be judged, in one line; `None` if it can.
#[must_use]
pub fn why_not(plan: &Plan, edits: &[Edit], twins: Option<usize>) -> Option<&'static str> {
    if !edits.is_empty() {
        Some("not judged: the run contains edits; undo them to judge it")
    } else if twins.is_some() {
        Some("not judged: its first passes ran on the CPU reference, and only runs on the device alone are judged")
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
        assert!(why_not(&plan, &[edit], None).is_some_and(|why| why.contains("edits")));
        assert!(why_not(&plan, &[], Some(3)).is_some_and(|why| why.contains("CPU reference")));
    }
}
