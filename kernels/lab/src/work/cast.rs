//! The rays that kernels cast while a run goes on, by kind: to what a hit reflects, and to lights.

use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::state::Tag;
use raystep_kernels::{Kernel, Pass, Plan};

/// Rays that were cast beside the primary ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cast {
    /// Rays that end at the nearest hit, as primary ones do; also those of photons.
    pub secondary: u64,
    /// Rays that end at any hit.
    pub shadow: u64,
}

/// Whether a kernel's rays have not begun to walk.
#[must_use]
pub fn begins_walks(kernel: Kernel) -> bool {
    matches!(kernel.role(), Role::Enter | Role::Whole)
}

/// Whether a kernel traces rays to any hit in a run of this plan.
#[must_use]
pub fn is_shadow(kernel: Kernel, plan: &Plan) -> bool {
    kernel.features(&plan.features).any_hit
}

impl Cast {
    /// The rays cast by the passes of a run, all of them from its start: those that a kernel after a walk has sent to one
    /// that begins walks, and those of photons as they are emitted. Rays that the run was given, or that its source
    /// generates, do not count, nor those of a kernel that follows whole paths.
    #[must_use]
    pub fn of(plan: &Plan, passes: &[Pass]) -> Self {
        let mut cast = Self::default();
        for (place, pass) in passes.iter().enumerate() {
            let before = place.checked_sub(1).map(|before| &passes[before].counts);
            for (is_shadow, tags) in cast_to(pass.kernel, plan) {
                let had = before.map_or(0, |counts| counts.in_any(&tags));
                let sent = u64::from(pass.counts.in_any(&tags).saturating_sub(had));
                *if is_shadow { &mut cast.shadow } else { &mut cast.secondary } += sent;
            }
        }
        cast
    }
}

/// The states into which a kernel casts rays, and whether those are shadow rays.
fn cast_to(kernel: Kernel, plan: &Plan) -> Vec<(bool, Vec<Tag>)> {
    let casts = match kernel.role() {
        Role::Finish => true,
        // Other elements than the camera's rays.
        Role::Source => kernel.course().map(|course| course.stream) != plan.program.state_stream(),
        _ => false,
    };
    if !casts {
        return Vec::new();
    }
    let is_sent = |tag: &Tag| kernel.sends().iter().any(|sent| sent.to == *tag);
    let beginning = plan.variants.iter().map(|variant| variant.kernel).filter(|&kernel| begins_walks(kernel));
    let of = |begins: Kernel| (is_shadow(begins, plan), begins.takes().iter().copied().filter(is_sent).collect());
    beginning.map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::options::{Integrator, Photons};
    use raystep_kernels::{Accelerator, Device, Options, RaySource, Renderer, Samples, ScheduleKind};
    use raystep_scenes::{Light, Scene, generate};

    use super::*;

    fn cast(scene: &Scene, options: &Options) -> Cast {
        let mut renderer = pollster::block_on(Renderer::new(scene, options, &Device::Cpu(None))).expect("a renderer");
        pollster::block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
        Cast::of(renderer.plan(), renderer.passes())
    }

    /// Every schedule casts as many rays, whichever kernels begin their walks, in one dispatch or several.
    #[test]
    fn rays_to_lights_are_counted_by_what_sends_them() {
        let mut scene = generate::cornell_box();
        let middle = (scene.bounds().min + scene.bounds().max) * 0.5;
        let camera = scene.cameras[0].clone();
        let options = Options {
            integrator: Integrator::Shadows,
            ..Options::new(RaySource::Camera { camera, width: 16, height: 12 })
        };
        let light = Light::Point { position: middle.to_array(), color: [1.0; 3], intensity: 1.0 };
        scene.lights = vec![light.clone()];
        let one = cast(&scene, &options);
        assert!(one.secondary == 0 && one.shadow > 100 && one.shadow <= 192, "{one:?}");
        // From the same place, every light gets as many.
        scene.lights = vec![light; 3];
        let three = Cast { shadow: 3 * one.shadow, ..one };
        for (schedule, steps_per_pass) in
            [(ScheduleKind::First, 1), (ScheduleKind::Second, 1), (ScheduleKind::Compact, 4), (ScheduleKind::Fused, 8)]
        {
            for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
                let options = Options { schedule, steps_per_pass, accelerator, ..options.clone() };
                assert_eq!(cast(&scene, &options), three, "{accelerator} {schedule}");
            }
        }
        let along_paths = Options { integrator: Integrator::Path, ..options.clone() };
        let whole = Options { schedule: ScheduleKind::Fused, ..along_paths.clone() };
        assert!(cast(&scene, &along_paths).secondary > 100 && cast(&scene, &whole) == Cast::default());
        let photons = Photons { count: 500, ..Photons::default() };
        let with_photons = Options { integrator: Integrator::Photons, photons, ..options.clone() };
        let of_photons = cast(&scene, &with_photons);
        // Emitted ones fill whole rows, and some bounce.
        assert!(of_photons.secondary > 504 && of_photons.shadow > 100, "{of_photons:?}");
        for schedule in [ScheduleKind::Second, ScheduleKind::Fused] {
            let options = Options { schedule, accelerator: Accelerator::Bvh, ..with_photons.clone() };
            assert_eq!(cast(&scene, &options), of_photons, "{schedule}");
        }
        let twice = Options { samples: Samples { count: 2, ..Samples::default() }, ..options.clone() };
        assert!(cast(&scene, &twice).shadow > three.shadow, "of both samples");
        for integrator in Integrator::ALL {
            let options = Options { integrator: *integrator, shade: false, ..options.clone() };
            assert_eq!(cast(&scene, &options), Cast::default(), "{integrator}: no light, no rays to it");
        }
        let local = Options { integrator: Integrator::Local, ..options };
        assert_eq!(cast(&scene, &local), Cast::default());
    }
}
