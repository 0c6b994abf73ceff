//! Rays that mirrors and glass send on: every kernel against its twin, every ray against f64, and one picture however traced.

use raystep_kernels::options::Integrator;
use raystep_kernels::options::mapping::{Fragment, Mapping};
use raystep_kernels::programs::closest_hit::streams::COLOR;
use raystep_kernels::programs::light::PROGRAM;
use raystep_kernels::{Accelerator, Device, Options, Plan, Ray, RaySource, Samples, ScheduleKind};
use raystep_scenes::Optics;
use raystep_tests::configurations::{Configuration, STEPPED};
use raystep_tests::{gpu, options, scene, traced, values};

use crate::bounced::{
    Run, balls, breaks_are_named, compare, glazed, have_one_picture, judge_all, takes_a_pass_for_each_triangle,
};

fn with_mirrors(options: Options) -> Options {
    Options { integrator: Integrator::Whitted, max_depth: 4, ..options }
}

#[test]
fn every_kernel_agrees_with_its_twin_after_every_pass() {
    let scenes = vec![("balls", balls()), ("lights", glazed(scene("lights.gltf")))];
    let runs = |options| -> Vec<Run> {
        let counted = Options { counters: true, ..with_mirrors(options) };
        let sampled =
            Options { samples: Samples { count: 2, ..Samples::default() }, counters: false, ..counted.clone() };
        vec![(counted.clone(), None), (sampled, None), (counted, Some(6))]
    };
    compare(scenes, [19, 15], 9, takes_a_pass_for_each_triangle, runs);
}

#[test]
fn every_ray_that_goes_on_is_right_and_none_hits_the_surface_that_it_leaves() {
    let sum = judge_all(glazed, with_mirrors, "illuminate");
    assert_eq!(sum.deepest, 4);
    assert!(20 * sum.ties < sum.rays, "{sum:?}");
}

#[test]
fn pictures_are_the_same_however_they_are_traced() {
    have_one_picture(&balls(), with_mirrors);
}

#[test]
fn what_cannot_be_sent_on_is_refused_with_what_would_work() {
    let scene = balls();
    let refused = |options: &Options| Plan::new(&scene, options, &(&*gpu()).into()).expect_err("refused").to_string();
    let drawn =
        Options { mapping: Mapping::Fragment(Fragment::default()), ..with_mirrors(STEPPED.of(&options(&scene, 8, 8))) };
    let why = refused(&drawn);
    assert!(why.contains("--mapping compute"), "{why}");
    let rays = vec![Ray { t_min: 0.5, ..Ray::new([0.0, 1.0, 5.0], [0.0, 0.0, -1.0]) }];
    let why = refused(&with_mirrors(Options::new(RaySource::Given(rays))));
    assert!(why.contains("t_min"), "{why}");
    // Without mirrors, rays are drawn.
    let mut matte = scene.clone();
    matte.materials.iter_mut().for_each(|material| material.optics = Optics::Diffuse);
    let [drawn, computed] = [drawn.mapping, Mapping::Compute].map(|mapping| {
        let options = Options { mapping, ..with_mirrors(STEPPED.of(&options(&matte, 8, 8))) };
        values(&traced(&matte, &options, &Device::Gpu(gpu())), COLOR)
    });
    assert!(drawn == computed);
}

#[test]
fn a_broken_kernel_is_named() {
    let scene = balls();
    let options = Configuration::new(Accelerator::Bvh, ScheduleKind::Fused, 1).of(&options(&scene, 24, 24));
    breaks_are_named(PROGRAM.kernel("scatter").expect("a kernel"), &scene, &options);
}
