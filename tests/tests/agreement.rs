//! Accelerators, schedules and executors find the same hits.

use std::collections::BTreeSet;

use raystep_kernels::numbers::real::ulps;
use raystep_kernels::{Accelerator, Renderer, ScheduleKind, Skip};
use raystep_lab::judge::sample;
use raystep_tests::configurations::EVERY;
use raystep_tests::{devices, hits, mistakes_among, options, scene, scene_files, thorough, traced};

/// Number of rays to judge in an image of more than 2,000 triangles, whether or not devices agree on them.
const JUDGED: usize = 2048;

#[test]
fn every_combination_ends_in_the_same_hits() {
    let mut failures = Vec::new();
    let gpu_is_software = raystep_tests::gpu().info.device_type == wgpu::DeviceType::Cpu;
    for (place, file) in scene_files().into_iter().enumerate() {
        let scene = scene(&file);
        let mut by_device = Vec::new();
        for (name, device) in devices() {
            let mut first: Option<(String, [Vec<u32>; 4], Renderer)> = None;
            for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
                // On two cores, brute force over more rays takes minutes.
                let size = match (scene.triangles.len() <= 60, thorough()) {
                    (true, true) => 256,
                    (false, true) => 96,
                    (true, false) => 64,
                    (false, false) => 40,
                };
                if accelerator == Accelerator::None && scene.triangles.len() > 2000 {
                    continue;
                }
                let schedules = [
                    (ScheduleKind::Second, 1, Skip::Off),
                    (ScheduleKind::First, 1, Skip::On),
                    (ScheduleKind::Compact, 1, Skip::On),
                    (ScheduleKind::Compact, 8, Skip::Off),
                    (ScheduleKind::Compact, 3, Skip::On),
                    (ScheduleKind::Fused, 1, Skip::Off),
                    (ScheduleKind::Fused, 1, Skip::On),
                ];
                for (row, (schedule, steps, skip)) in schedules.into_iter().enumerate() {
                    // Every combination is tried on one scene in seven; in the full suite, on every scene.
                    if row > 0 && (row + place) % 7 > 0 && !thorough() {
                        continue;
                    }
                    if accelerator != Accelerator::Grid && skip == Skip::On && schedule != ScheduleKind::Compact {
                        continue; // nothing to skip, or the same schedule
                    }
                    let mut options = options(&scene, size, size);
                    (options.accelerator, options.schedule, options.shade) = (accelerator, schedule, false);
                    (options.steps_per_pass, options.skip) = (steps, skip);
                    let renderer = traced(&scene, &options, &device);
                    assert_eq!(renderer.unfinished(), 0, "{file} {accelerator} {schedule}");
                    let found = hits(&renderer);
                    let label = format!("{accelerator} {schedule} {steps} skip {skip}");
                    match &first {
                        None => first = Some((label, found, renderer)),
                        Some((reference, expected, _)) if *expected != found => {
                            let differs = |i: &usize| (0..4).any(|c| expected[c][*i] != found[c][*i]);
                            let differ = (0..found[0].len()).filter(differs);
                            failures.push(format!(
                                "{file} {name}: {label} differs from {reference} on {} rays",
                                differ.count()
                            ));
                        }
                        Some(_) => {}
                    }
                }
            }
            by_device.extend(first);
        }
        // Across executors: the same bits if the adapter rounds every operation as the host does, as Mesa's software
        // Vulkan does; otherwise both are correct except for ties.
        let [(_, gpu, on_gpu), (_, cpu, on_cpu)] = &by_device[..] else { panic!("two devices") };
        let rays = gpu[0].len();
        let differ: Vec<usize> = (0..rays).filter(|&i| (0..4).any(|c| gpu[c][i] != cpu[c][i])).collect();
        let count = if scene.triangles.len() <= 2000 { rays } else { JUDGED };
        let judged: BTreeSet<usize> = differ.iter().copied().chain(sample(rays, count, 1)).collect();
        let judged: Vec<usize> = judged.into_iter().collect();
        for (name, renderer) in [("gpu", on_gpu), ("cpu", on_cpu)] {
            let mistakes = mistakes_among(renderer, &judged);
            if !mistakes.is_empty() {
                failures.push(format!("{file} {name}: {} of {} rays: {mistakes:?}", mistakes.len(), judged.len()));
            }
        }
        if gpu_is_software && !differ.is_empty() {
            failures.push(format!("{file}: {} of {rays} rays differ between gpu and cpu", differ.len()));
        }
        let largest = differ.iter().map(|&i| ulps(gpu[0][i], cpu[0][i])).max().unwrap_or(0);
        println!("{file}: {} of {rays} rays differ between gpu and cpu, t by {largest} ulp at most", differ.len());
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Both executors run the same passes.
#[test]
fn both_executors_take_the_same_passes() {
    for file in ["cornell-box.gltf", "sphere-flake.glb"] {
        let scene = scene(file);
        for configuration in EVERY.iter().filter(|configuration| configuration.accelerator != Accelerator::None) {
            let options = configuration.of(&options(&scene, 64, 64));
            let [on_gpu, on_cpu] = [0, 1].map(|i| traced(&scene, &options, &devices()[i].1));
            let passes = |r: &Renderer| r.passes().iter().map(|p| p.kernel).collect::<Vec<_>>();
            let (left, right) = (passes(&on_gpu), passes(&on_cpu));
            // A ray on a rounding boundary may enter another cell on a GPU with inexact division, and then visit one or
            // two cells more.
            assert!(
                left.len().abs_diff(right.len()) <= 4,
                "{file} {configuration}: {} and {} passes",
                left.len(),
                right.len()
            );
            let parted = left.iter().zip(&right).position(|(a, b)| a != b);
            let shorter = left.len().min(right.len());
            assert!(parted.is_none_or(|i| i + 4 >= shorter), "{file} {configuration}: part at {parted:?} of {shorter}");
        }
    }
}
