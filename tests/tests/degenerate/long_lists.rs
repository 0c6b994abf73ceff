//! More work for one ray than a thread can do in one dispatch: lists of tens and hundreds of thousands of triangles,
//! and as many lights. Mesa's software Vulkan silently ends loops after 65,535 iterations.

use std::ops::ControlFlow;

use glam::DVec3;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{Accelerator, Device, GridSize, Limits, Loops, Options, Plan, RaySource, Renderer, ScheduleKind};
use raystep_scenes::{Camera, Light, Projection, Scene};
use raystep_tests::configurations::{Configuration, EVERY};
use raystep_tests::{block_on, devices, gpu, gpu_of, hits, options, scene, thorough, values};

use super::{expect_no_errors, made_of, picture};

/// A pile of triangles, the last one nearest to the eye. All cover the same half of their boxes, so that half of the
/// rays through the boxes enter every box and hit nothing.
fn pile(count: usize) -> Scene {
    let z = |i: usize| i as f32 / count as f32;
    made_of((0..count).map(|i| [[-1.0, -1.0, z(i)], [1.0, -1.0, z(i)], [1.0, 1.0, z(i)]]).collect())
}

/// Parallel rays along the pile, which meet boxes and cells in the order of z.
fn along(scene: &Scene, side: u32) -> Options {
    let mut options = picture(scene, side);
    if let RaySource::Camera { camera, .. } = &mut options.rays {
        let projection = Projection::Orthographic { half_height: 1.1 };
        let (eye, target) = (DVec3::new(0.05, 0.02, 5.0), DVec3::new(0.05, 0.02, 0.0));
        *camera = Camera::look_at(eye, target, DVec3::Y, projection).expect("an eye off its target");
    }
    options
}

/// Configurations that take several steps per pass, or all of them.
fn several() -> Vec<Configuration> {
    let all_steps = [Accelerator::None, Accelerator::Bvh, Accelerator::Grid]
        .map(|accelerator| Configuration::new(accelerator, ScheduleKind::Compact, 4096));
    let is_one = |configuration: &Configuration| {
        (configuration.steps > 1 || !configuration.is_stepped()) && configuration.accelerator != Accelerator::Irregular
    };
    EVERY.into_iter().filter(is_one).chain(all_steps).collect()
}

fn in_one_cell(scene: &Scene, side: u32) -> Options {
    Options { grid: GridSize::Cells([1; 3]), ..along(scene, side) }
}

#[test]
fn lists_longer_than_any_loop_are_walked_to_their_end() {
    let scene = pile(70_000);
    // With the automatic grid, and with a single cell that lists everything.
    let side = if thorough() { 12 } else { 3 };
    expect_no_errors("pile", &scene, &along(&scene, side), &several(), 0.0);
    let grids: Vec<Configuration> =
        several().into_iter().filter(|configuration| configuration.accelerator == Accelerator::Grid).collect();
    expect_no_errors("pile in one cell", &scene, &in_one_cell(&scene, side), &grids, 0.0);
}

/// One triangle per pass: as many passes as there are triangles.
#[test]
#[ignore = "long: sh tests/full.sh"]
fn lists_longer_than_any_loop_are_walked_step_by_step() {
    let scene = pile(70_000);
    let stepped = [
        Configuration::new(Accelerator::None, ScheduleKind::Second, 1),
        Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 1),
    ];
    let side = if thorough() { 4 } else { 3 };
    expect_no_errors("pile, step by step", &scene, &in_one_cell(&scene, side), &stepped, 0.0);
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn lists_several_times_as_long_as_any_loop_are_walked_to_their_end() {
    let scene = pile(300_000);
    let is_long = |configuration: &Configuration| {
        thorough() || configuration.schedule == ScheduleKind::Fused || configuration.steps == 4096
    };
    let (side, configurations) = (if thorough() { 6 } else { 4 }, several().into_iter().filter(is_long));
    expect_no_errors("larger pile", &scene, &in_one_cell(&scene, side), &configurations.collect::<Vec<_>>(), 0.0);
}

/// A ray's counters do not depend on the number of dispatches.
#[test]
fn counters_are_of_the_walk_and_not_of_its_dispatches() {
    let scene = pile(70_000);
    let device = Device::Gpu(gpu());
    let side = if thorough() { 8 } else { 5 };
    let mut sums = Vec::new();
    for cells in [[1, 1, 1], [2, 3, 40]] {
        let others = EVERY.into_iter().filter(|configuration| configuration.accelerator != Accelerator::Irregular);
        for configuration in others.filter(|configuration| configuration.steps > 1 || !configuration.is_stepped()) {
            let options = Options {
                counters: true,
                shade: true,
                grid: GridSize::Cells(cells),
                ..configuration.of(&along(&scene, side))
            };
            let [on_gpu, on_cpu] = [&device, &Device::Cpu(Option::None)].map(|device| {
                let renderer = run(&scene, &options, device, Option::None);
                values(&renderer, streams::COUNTERS)
            });
            // A walk that continues in a later dispatch enters fewer boxes, because of hits found in the meantime.
            let exact = configuration.accelerator != Accelerator::Bvh || configuration.is_stepped();
            for layer in 0..3 {
                let (ours, theirs) = (on_gpu.layer(layer), on_cpu.layer(layer));
                let is_right = if exact { ours == theirs } else { ours.iter().zip(theirs).all(|(a, b)| a <= b) };
                assert!(is_right, "{configuration}, cells {cells:?}, counter {layer}: {ours:?}, on the CPU {theirs:?}");
            }
            sums.push(on_gpu.layer(1).iter().map(|&tests| u64::from(tests)).sum::<u64>());
        }
    }
    assert!(sums.iter().all(|&tests| tests > 70_000), "{sums:?}");
}

/// Copies of one triangle, which no division of cells tells apart: a list of the irregular grid is as long.
#[test]
fn a_list_of_the_irregular_grid_is_walked_in_several_dispatches() {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.5]];
    let scene = made_of(vec![corners; 70_000]);
    let options = Options { counters: true, ..along(&scene, 6) };
    let expected = run(
        &scene,
        &Configuration::new(Accelerator::None, ScheduleKind::Fused, 1).of(&options),
        &Device::Cpu(None),
        None,
    );
    for schedule in [ScheduleKind::Fused, ScheduleKind::Compact] {
        let configuration = Configuration::new(Accelerator::Irregular, schedule, 8);
        let [on_gpu, on_cpu] = [Device::Gpu(gpu()), Device::Cpu(None)].map(|device| {
            let renderer = run(&scene, &configuration.of(&options), &device, None);
            assert!(renderer.plan().features.resumes || !device.is_gpu(), "{configuration}: one dispatch suffices");
            assert!(hits(&renderer) == hits(&expected), "{configuration}");
            values(&renderer, streams::COUNTERS)
        });
        assert_eq!(on_gpu.bits, on_cpu.bits, "{configuration}");
        assert!(on_gpu.layer(1).iter().any(|&tests| tests >= 70_000), "{configuration}");
    }
}

/// Searches for repeated tests along many cells with long lists.
#[test]
fn repeated_tests_are_counted_by_a_search_of_several_dispatches() {
    // Slivers along the rays, listed in every cell on the way, and a wall at the end, listed only there.
    let mut triangles: Vec<_> =
        (0..40).map(|i| [[-0.5, i as f32 * 0.01, 0.0], [0.5, 0.0, 0.0], [0.5, 0.1, 1.0]]).collect();
    triangles.push([[-3.0, -2.0, 0.0], [3.0, -2.0, 0.0], [0.0, 3.0, 0.0]]);
    let scene = made_of(triangles);
    let options = Options { counters: true, grid: GridSize::Cells([1, 1, 900]), ..along(&scene, 6) };
    let options = Configuration::new(Accelerator::Grid, ScheduleKind::Second, 1).of(&options);
    let limits = Limits { turns: 500, ..Limits::from(&*gpu()) };
    let in_turns = run(&scene, &options, &Device::Gpu(gpu()), Some(&limits));
    let whole = run(&scene, &options, &Device::Cpu(None), Option::None);
    assert!(in_turns.plan().features.resumes_scan && !whole.plan().features.resumes_scan);
    let [ours, theirs] = [&in_turns, &whole].map(|renderer| values(renderer, streams::COUNTERS));
    assert_eq!(ours, theirs);
    assert!(theirs.layer(2).iter().any(|&repeated| repeated > 100), "{:?}", theirs.layer(2));
    assert!(in_turns.passes().len() > whole.passes().len(), "no search took a second dispatch");
}

/// One light and 69,999 zeros, whose sum is exact: 64 roundings of values below 1, as parity allows for a kernel that
/// shades with a light without a cone.
const LIGHT_TOLERANCE: f32 = 64.0 * f32::EPSILON;

/// Index of the first float in two lists that differs by more than `tolerance`, or exists in only one of them. NaN
/// differs from everything.
fn first_apart(a: &[u32], b: &[u32], tolerance: f32) -> Option<usize> {
    let is_near = |a: f32, b: f32| a == b || (a - b).abs() <= tolerance;
    let near = a.iter().zip(b).take_while(|(a, b)| is_near(f32::from_bits(**a), f32::from_bits(**b))).count();
    (near < a.len().max(b.len())).then_some(near)
}

#[test]
fn nan_and_missing_texels_are_apart() {
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    for (a, b, apart) in [
        (&[0.5, f32::INFINITY, 1.0][..], &[0.5 + f32::EPSILON, f32::INFINITY, 1.0][..], Option::None),
        (&[0.5, 0.25], &[0.5, 0.2501], Some(1)),
        (&[f32::NAN], &[f32::NAN], Some(0)),
        (&[0.5, f32::NAN], &[0.5, 0.0], Some(1)),
        (&[0.5], &[0.5, 0.5], Some(1)),
        (&[0.5, 0.5], &[0.5], Some(1)),
    ] {
        assert_eq!(first_apart(&bits(a), &bits(b), LIGHT_TOLERANCE), apart, "{a:?} {b:?}");
    }
}

/// Only the last of 70,000 lights shines.
#[test]
fn all_lights_are_summed() {
    let mut scene = scene("single-triangle.gltf");
    let dark = Light::Point { position: [0.0, 0.0, 3.0], color: [0.0; 3], intensity: 0.0 };
    scene.lights = vec![dark; 69_999];
    scene.lights.push(Light::Point { position: [0.3, 0.2, 3.0], color: [1.0, 0.5, 0.25], intensity: 1.0 });
    for configuration in EVERY {
        let options = configuration.of(&options(&scene, 9, 9));
        let picture = |(_, device)| values(&run(&scene, &options, &device, Option::None), streams::COLOR);
        let pictures: Vec<_> = devices().into_iter().map(picture).collect();
        assert!(pictures[0].layer(0).iter().any(|&red| f32::from_bits(red) > 0.1), "{configuration}: dark");
        let [on_gpu, on_cpu] = [&pictures[0].bits, &pictures[1].bits];
        if gpu().is_software() {
            // Software Vulkan rounds every operation as the CPU does.
            assert_eq!(on_gpu, on_cpu, "{configuration}");
        } else {
            let apart = first_apart(on_gpu, on_cpu, LIGHT_TOLERANCE);
            assert_eq!(apart, Option::None, "{configuration}: the first texel that differs too much");
        }
    }
}

/// With any number of loop iterations per dispatch, down to one, hits have the same bits.
#[test]
fn the_number_of_loop_turns_changes_no_hit() {
    for file in ["cornell-box.gltf", "teapot.glb"] {
        let scene = scene(file);
        for (name, device) in devices() {
            for configuration in EVERY
                .into_iter()
                .filter(|configuration| configuration.accelerator != Accelerator::None || scene.triangles.len() < 100)
            {
                let options = configuration.of(&options(&scene, 30, 20));
                let whole = run(&scene, &options, &device, Some(&Limits { turns: u32::MAX, ..Limits::CPU }));
                assert!(!whole.plan().features.resumes);
                for turns in [1, 7, 64] {
                    let limits = Limits { turns, ..Limits::CPU };
                    let parts = run(&scene, &options, &device, Some(&limits));
                    // With one iteration, everything that can continue later does; with more, what may need to.
                    let resumes = turns == 1 && (configuration.steps > 1 || !configuration.is_stepped());
                    assert!(parts.plan().features.resumes >= resumes, "{file} {name} {configuration} {turns}");
                    assert!(!resumes || parts.passes().len() > whole.passes().len(), "{file} {name} {configuration}");
                    assert_eq!(hits(&parts), hits(&whole), "{file} {name} {configuration}, {turns} turns");
                    assert_eq!(
                        values(&parts, streams::COLOR),
                        values(&whole, streams::COLOR),
                        "{file} {name} {configuration}"
                    );
                }
            }
        }
    }
}

/// If no thread can exceed its number of iterations, nothing is compiled or allocated for continuing.
#[test]
fn what_fits_one_dispatch_is_compiled_as_without_a_limit() {
    let scene = scene("cornell-box.gltf");
    for configuration in EVERY {
        let options = Options { counters: true, ..configuration.of(&options(&scene, 16, 16)) };
        let [many, without] = [1 << 22, u32::MAX]
            .map(|turns| Plan::new(&scene, &options, &Limits { turns, ..Limits::CPU }).expect("a plan").0);
        assert_eq!(many.bytes(), without.bytes(), "{configuration}");
        for (many, without) in many.variants.iter().zip(&without.variants) {
            assert_eq!(many.source, without.source, "{configuration}: {}", many.kernel.name());
        }
        assert!(
            ![streams::PLACE, streams::TRAIL, streams::SCAN].iter().any(|&s| many.has_stream(s)),
            "{configuration}"
        );
    }
}

/// Mesa's software Vulkan is known to end loops; a thread gets a small part of the iterations that it allows.
#[test]
fn the_adapters_loops_are_probed() {
    let gpu = gpu();
    let limits = Limits::from(&*gpu);
    println!("{}: {:?}, {} turns a dispatch", gpu.info.name, gpu.loops, limits.turns);
    match gpu.loops {
        Loops::EndAfter(turns) => assert!(limits.turns >= 1 && limits.turns <= turns / 16),
        Loops::Unlimited => assert!(limits.turns > 65_535),
    }
    if gpu.info.name.contains("llvmpipe") {
        assert!(matches!(gpu.loops, Loops::EndAfter(65_000..66_000)), "{:?}", gpu.loops);
    }
}

fn run(scene: &Scene, options: &Options, device: &Device, limits: Option<&Limits>) -> Renderer {
    block_on(gpu_of(device), async {
        let mut renderer = match limits {
            Some(limits) => {
                let (plan, data) = Plan::new(scene, options, limits).expect("a plan");
                Renderer::from_plan(plan, data, options, device).await
            }
            Option::None => Renderer::new(scene, options, device).await,
        }
        .expect("a renderer");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
        renderer
    })
}
