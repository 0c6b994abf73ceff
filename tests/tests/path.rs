//! Paths: every kernel against its twin, every ray against f64, and pictures in parts.

use raystep_kernels::options::{Integrator, Strategy};
use raystep_kernels::programs::closest_hit::streams::COLOR;
use raystep_kernels::programs::path::PROGRAM;
use raystep_kernels::{Accelerator, Options, Samples, ScheduleKind, StreamData};
use raystep_scenes::{Optics, Scene};
use raystep_tests::configurations::{COVERING, Configuration};
use raystep_tests::{devices, gpu, options, parity, scene, scene_files, thorough, traced, values};

use crate::whitted::{Judged, balls, glazed, judged};

fn along_paths(options: Options) -> Options {
    Options { integrator: Integrator::Path, max_depth: 5, ..options }
}

/// The glass ball, and a diffuse one, over a floor of which every other tile glows.
pub(crate) fn glowing() -> Scene {
    let mut scene = balls();
    scene.materials[0].emissive = [0.25, 0.5, 0.125];
    scene.materials[3].optics = Optics::Diffuse;
    scene
}

#[test]
fn every_kernel_agrees_with_its_twin_after_every_pass() {
    let (mut failures, mut passes) = (Vec::new(), 0);
    // Lights of every kind; surfaces that glow, on one side or on both; and textures.
    let scenes =
        [("glowing", glowing()), ("lights", glazed(scene("lights.gltf"))), ("textures", scene("textures.gltf"))];
    for (place, (name, scene)) in scenes.into_iter().enumerate() {
        for (row, configuration) in COVERING.into_iter().enumerate() {
            // Without a structure, these take a pass for each triangle of each ray.
            let is_long = configuration.is_stepped() && configuration.accelerator == Accelerator::None;
            if is_long || (row + place) % 4 > 0 && !thorough() {
                continue;
            }
            let options = along_paths(configuration.of(&options(&scene, 19, 15)));
            let counted = Options { counters: true, ..options.clone() };
            let sampled = Options { samples: Samples { count: 2, ..Samples::default() }, ..options.clone() };
            let by_light = Options { strategy: Strategy::Light, ..options.clone() };
            let by_chance = Options { strategy: Strategy::Bsdf, ..options };
            let runs = [(&counted, None), (&sampled, None), (&by_light, None), (&by_chance, Some(6))];
            for &(options, turns) in if thorough() { &runs[..] } else { &runs[(row / 4 + place) % 4..][..1] } {
                let found = match turns {
                    Some(turns) => parity::compare_in_turns(&gpu(), &scene, options, turns),
                    None => parity::compare(&gpu(), &scene, options),
                };
                let label = format!("{name} {configuration} {} turns {turns:?}", options.strategy);
                failures.extend(found.breaches.iter().map(|breach| format!("{label}: {breach}")));
                failures.extend(found.miscounts.iter().map(|miscount| format!("{label}: {miscount}")));
                passes += found.compared.total().passes;
            }
        }
    }
    assert!(passes > 1_000, "{passes} passes");
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures[..failures.len().min(9)].join("\n"));
}

#[test]
fn every_ray_of_every_path_is_right_and_none_hits_the_surface_that_it_leaves() {
    let mut sum = Judged::default();
    for (place, file) in scene_files().into_iter().enumerate() {
        let scene = scene(&file);
        for (row, accelerator) in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh].into_iter().enumerate()
        {
            if (place + row) % 3 > 0 && !thorough() {
                continue;
            }
            let side = if thorough() { 128 } else { 32 };
            let of = Configuration::new(accelerator, ScheduleKind::Fused, 1);
            let options = along_paths(of.of(&options(&scene, side, side)));
            let (name, device) = &devices()[place % 2];
            let found = judged(&scene, &options, device, "sample_light");
            assert_eq!(found.wrong, [""; 0], "{file} {of} on {name}");
            assert_eq!(found.own, 0, "{file} {of} on {name}: rays hit the surface that they leave");
            sum.rays += found.rays;
            sum.ties += found.ties;
            sum.deepest = sum.deepest.max(found.deepest);
        }
    }
    println!("{} rays, {} ties", sum.rays, sum.ties);
    assert!(sum.rays > 10_000 && sum.deepest == 5, "{sum:?}");
    assert!(50 * sum.ties < sum.rays, "{sum:?}");
}

/// A picture has the same bytes by every structure and schedule on one device.
#[test]
fn pictures_are_the_same_however_they_are_traced() {
    let scene = glowing();
    for (name, device) in devices() {
        let mut first: Option<StreamData> = None;
        for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
            for schedule in [ScheduleKind::Compact, ScheduleKind::Fused] {
                let of = Configuration::new(accelerator, schedule, 8);
                let color = values(&traced(&scene, &along_paths(of.of(&options(&scene, 24, 24))), &device), COLOR);
                let first = first.get_or_insert_with(|| color.clone());
                assert!(*first == color, "{of} on {name}");
            }
        }
    }
}

#[test]
fn a_broken_kernel_is_named() {
    let scene = glowing();
    for name in ["sample_light", "sample_bsdf"] {
        let kernel = PROGRAM.kernel(name).expect("a kernel");
        for broken in kernel.info().breaks {
            let of = Configuration::new(Accelerator::Bvh, ScheduleKind::Fused, 1);
            let mut options = along_paths(of.of(&options(&scene, 24, 24)));
            options.samples = Samples { count: 2, ..Samples::default() };
            (broken.run)(&mut options);
            let found = parity::compare_broken(&gpu(), &scene, &options, |plan| {
                let variant = plan.variants.iter_mut().find(|v| v.kernel == kernel).expect("in the plan");
                variant.source = parity::change(&variant.source, broken.from, broken.to);
            });
            assert_eq!(found.breaches.first().map(|b| b.kernel), Some(kernel), "{name} with {:?}", broken.to);
        }
    }
}
