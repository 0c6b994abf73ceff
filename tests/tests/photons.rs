//! Photon maps: every kernel against its twin, one picture however it is found, and the same maps on every device.

use raystep_kernels::options::{Gather, Integrator, Neighbours, PhotonSort, Photons};
use raystep_kernels::programs::closest_hit::streams::{PHOTON_FIRST, PHOTON_KEY};
use raystep_kernels::programs::photons::PROGRAM;
use raystep_kernels::{Accelerator, Options, Samples, ScheduleKind};
use raystep_scenes::generate;
use raystep_tests::configurations::Configuration;
use raystep_tests::{devices, options, scene, thorough, traced, values};

use crate::bounced::{Run, breaks_are_named, compare, glazed, have_one_picture, takes_a_pass_for_each_triangle};
use crate::path::glowing;

fn few() -> Photons {
    Photons { count: 300, radius: 100, nearest: 10, ..Photons::default() }
}

fn by_photons(options: Options) -> Options {
    Options { integrator: Integrator::Photons, max_depth: 4, photons: few(), ..options }
}

#[test]
fn every_kernel_agrees_with_its_twin_after_every_pass() {
    let scenes =
        vec![("glowing", glowing()), ("lights", glazed(scene("lights.gltf"))), ("textures", scene("textures.gltf"))];
    let runs = |options| -> Vec<Run> {
        let options = by_photons(options);
        let of = |photons| Options { photons, ..options.clone() };
        let final_gather = of(Photons { gather: Gather::Final, ..few() });
        let sampled = Options { samples: Samples { count: 2, ..Samples::default() }, ..final_gather };
        let exact = of(Photons { neighbours: Neighbours::Exact, sort: PhotonSort::Bitonic, ..few() });
        vec![(Options { counters: true, ..options.clone() }, None), (sampled, None), (exact, None), (options, Some(6))]
    };
    compare(scenes, [11, 9], 17, takes_a_pass_for_each_triangle, runs);
}

#[test]
fn pictures_are_the_same_however_they_are_traced() {
    have_one_picture(&glowing(), by_photons);
}

#[test]
fn a_broken_kernel_is_named() {
    // Where photons meet everything: a lamp with an area and one without, walls, a mirror, and glass.
    let mut scene = generate::cornell_balls(1).expect("a scene");
    scene.lights = generate::cornell_box().lights;
    let base = Configuration::new(Accelerator::Bvh, ScheduleKind::Compact, 8).of(&options(&scene, 16, 16));
    for name in ["emit_photons", "scatter_photons", "key_photons", "search_cells", "look_up", "gather"] {
        // Some searches find more than they want.
        let photons = Photons { count: 1000, nearest: 5, radius: 200, ..few() };
        let options = Options { photons, ..by_photons(base.clone()) };
        breaks_are_named(PROGRAM.kernel(name).expect("a kernel"), &scene, &options);
    }
}

/// By either sort, on every device, keys are those of a stable sort: by cell, then by record, and none is lost. Thorough
/// tests sort as many as there may be.
#[test]
fn both_sorts_leave_the_lists_of_a_stable_sort() {
    let count = if thorough() { 1 << 20 } else { 3000 };
    for (name, device) in devices() {
        let of = |sort| {
            let base = Configuration::new(Accelerator::Bvh, ScheduleKind::Fused, 1).of(&options(&glowing(), 8, 8));
            let photons = Photons { count, radius: 20, sort, ..few() };
            let renderer = traced(&glowing(), &Options { photons, max_depth: 5, ..by_photons(base) }, &device);
            let records = renderer.size(PHOTON_KEY.info().elements).expect("a size").count as usize;
            let [key, first] = [PHOTON_KEY, PHOTON_FIRST].map(|stream| values(&renderer, stream));
            let sorted: Vec<_> = (0..records).map(|i| (key.get(0, i), key.get(1, i))).collect();
            assert!(sorted.is_sorted_by(|a, b| a < b), "{name}, {sort}");
            let mut is_there = vec![false; records];
            sorted.iter().for_each(|&(_, record)| is_there[record as usize] = true);
            assert!(is_there.iter().all(|&is| is), "{name}, {sort}");
            (sorted, first)
        };
        assert!(of(PhotonSort::Bitonic) == of(PhotonSort::Scan), "{name}");
    }
}
