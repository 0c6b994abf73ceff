//! Paths: every kernel against its twin, every ray against f64, and one picture however traced.

use raystep_kernels::options::{Integrator, Strategy};
use raystep_kernels::programs::path::PROGRAM;
use raystep_kernels::{Accelerator, Options, Samples, ScheduleKind};
use raystep_scenes::{Optics, Scene, generate};
use raystep_tests::configurations::Configuration;
use raystep_tests::{gpu, options, parity, scene};

use crate::bounced::{
    Run, balls, breaks_are_named, compare, glazed, have_one_picture, judge_all, takes_a_pass_for_each_triangle,
};

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
    // Lights of every kind; surfaces that glow, on one side or on both; and textures.
    let scenes =
        vec![("glowing", glowing()), ("lights", glazed(scene("lights.gltf"))), ("textures", scene("textures.gltf"))];
    let runs = |options| -> Vec<Run> {
        let options = along_paths(options);
        let sampled = Options { samples: Samples { count: 2, ..Samples::default() }, ..options.clone() };
        let by_light = Options { strategy: Strategy::Light, ..options.clone() };
        let by_chance = Options { strategy: Strategy::Bsdf, ..options.clone() };
        let counted = Options { counters: true, ..options };
        vec![(counted, None), (sampled, None), (by_light, None), (by_chance, Some(6))]
    };
    compare(scenes, [19, 15], 9, takes_a_pass_for_each_triangle, runs);
}

/// So small that one kernel follows whole paths on any device: it binds eight storage buffers, and takes few loop turns.
fn small() -> Scene {
    generate::cornell_lamp()
}

#[test]
fn whole_paths_agree_with_their_twin() {
    let (scene, kernel) = (small(), PROGRAM.kernel("fused_path").expect("a kernel"));
    for accelerator in [Accelerator::Bvh, Accelerator::None] {
        let options = along_paths(Configuration::new(accelerator, ScheduleKind::Fused, 1).of(&options(&scene, 24, 16)));
        let samples = Samples { count: 2, ..Samples::default() };
        for options in [Options { samples, ..options.clone() }, Options { counters: true, ..options }] {
            let found = parity::compare(&gpu(), &scene, &options);
            assert_eq!(found.breaches.iter().map(ToString::to_string).collect::<Vec<_>>(), [""; 0], "{accelerator}");
            assert!(found.miscounts.is_empty() && found.transitions.iter().any(|(_, by, _)| *by == kernel));
        }
    }
}

#[test]
fn every_ray_of_every_path_is_right_and_none_hits_the_surface_that_it_leaves() {
    let sum = judge_all(|scene| scene, along_paths, "sample_light");
    assert_eq!(sum.deepest, 5);
    assert!(50 * sum.ties < sum.rays, "{sum:?}");
}

#[test]
fn pictures_are_the_same_however_they_are_traced() {
    have_one_picture(&glowing(), along_paths);
    have_one_picture(&small(), along_paths);
}

#[test]
fn a_broken_kernel_is_named() {
    for (name, scene, schedule) in [
        ("sample_light", glowing(), ScheduleKind::Compact),
        ("sample_bsdf", glowing(), ScheduleKind::Compact),
        ("fused_path", small(), ScheduleKind::Fused),
    ] {
        let of = Configuration::new(Accelerator::Bvh, schedule, 8);
        let mut options = along_paths(of.of(&options(&scene, 24, 24)));
        options.samples = Samples { count: 2, ..Samples::default() };
        breaks_are_named(PROGRAM.kernel(name).expect("a kernel"), &scene, &options);
    }
}
