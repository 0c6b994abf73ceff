//! What passes add to the counters: by pass, by sample and over all of them, on every device.

use std::ops::ControlFlow;

use raystep_kernels::renderer::{Counted, CounterSums};
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::{Accelerator, Device, Limits, Options, Plan, Renderer, Samples, ScheduleKind};
use raystep_scenes::{Scene, generate};
use raystep_tests::configurations::{Configuration, EVERY};
use raystep_tests::{block_on, devices, gpu, gpu_of, options, scene, traced};

/// Counts a run, with each pass on its own or not. With `turns`, one dispatch allows fewer turns of loops.
fn counted(
    scene: &Scene,
    options: &Options,
    device: &Device,
    turns: Option<u32>,
    each_pass: bool,
) -> (Renderer, Counted) {
    let limits = if device.is_gpu() { Limits::from(&*gpu()) } else { Limits::CPU };
    let limits = turns.map_or(limits, |turns| Limits { turns, ..limits });
    let (plan, data) = Plan::new(scene, options, &limits).expect("a plan");
    block_on(gpu_of(device), async {
        let mut renderer = Renderer::from_plan(plan, data, options, device).await.expect("a renderer");
        let counted = renderer.run_counting(each_pass, |_| ControlFlow::Continue(())).await.expect("a run");
        (renderer, counted.expect("counters"))
    })
}

fn sum<'a>(passes: impl IntoIterator<Item = &'a CounterSums>) -> [u64; 2] {
    passes.into_iter().fold([0; 2], |[cells, tests], p| [cells + p.cells_visited, tests + p.triangles_tested])
}

fn both(sums: CounterSums) -> [u64; 2] {
    [sums.cells_visited, sums.triangles_tested]
}

#[test]
fn sums_of_passes_are_those_of_the_run_and_of_each_sample_alone() {
    let scene = scene("cornell-box.gltf");
    for configuration in EVERY {
        let base = Options { counters: true, ..configuration.of(&options(&scene, 24, 18)) };
        let of = |first, count| Options { samples: Samples { first, count, ..Samples::default() }, ..base.clone() };
        for (name, device) in devices() {
            let (renderer, by_pass) = counted(&scene, &of(5, 3), &device, None, true);
            let (_, at_once) = counted(&scene, &of(5, 3), &device, None, false);
            assert_eq!((by_pass.sums, at_once.passes.len()), (at_once.sums, 0), "{configuration}, {name}");
            let passes = renderer.passes();
            assert_eq!(by_pass.passes.len(), passes.len(), "{configuration}, {name}");
            let mut hits = 0;
            for sample in 0..3 {
                let alone = traced(&scene, &of(5 + sample, 1), &device);
                let expected = block_on(gpu_of(&device), alone.counter_sums()).expect("values").expect("counters");
                let own = by_pass.passes.iter().zip(passes).filter(|(_, pass)| pass.sample == sample);
                assert_eq!(
                    sum(own.map(|(counted, _)| counted)),
                    both(expected),
                    "{configuration}, {name}, sample {sample}"
                );
                hits += block_on(gpu_of(&device), alone.image()).expect("an image").hits(1);
            }
            let image = block_on(gpu_of(&device), renderer.image()).expect("an image");
            assert_eq!(image.hits(3), hits, "{configuration}, {name}");
            for (counted, pass) in by_pass.passes.iter().zip(passes) {
                let counts = both(*counted);
                match pass.kernel.role() {
                    Role::Source | Role::Finish | Role::Sample => {
                        assert_eq!(counts, [0; 2], "{configuration}, {name}: {pass:?}")
                    }
                    // An empty list has no triangle to test.
                    Role::Test => {
                        assert!(counts[0] == 0 && counts[1] <= u64::from(pass.rays_in), "{configuration}: {pass:?}")
                    }
                    Role::Step => {
                        assert!(counts[1] == 0 && counts[0] <= u64::from(pass.rays_in), "{configuration}: {pass:?}")
                    }
                    _ => {}
                }
            }
        }
    }
}

#[test]
fn a_pass_that_continues_walks_counts_only_its_own_work() {
    let scene = generate::soup(1000, 1).expect("a soup");
    for accelerator in [Accelerator::None, Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh] {
        for schedule in [ScheduleKind::Fused, ScheduleKind::Compact] {
            let configuration = Configuration::new(accelerator, schedule, 4096);
            let samples = Samples { count: 2, ..Samples::default() };
            let options = Options { counters: true, samples, ..configuration.of(&options(&scene, 16, 16)) };
            for (name, device) in devices() {
                // As few turns as make many rays wait.
                let turns = if accelerator == Accelerator::Bvh { 8 } else { 64 };
                let (renderer, few) = counted(&scene, &options, &device, Some(turns), true);
                let (_, whole) = counted(&scene, &options, &device, None, true);
                let is_walk = |role| matches!(role, Role::Whole | Role::Walk);
                let walks: Vec<_> = few.passes.iter().zip(renderer.passes()).collect();
                let walks = walks.iter().filter(|(_, pass)| is_walk(pass.kernel.role()));
                assert!(walks.clone().count() > 2, "{configuration}, {name}: no walk was continued");
                assert_eq!(sum(&few.passes), both(few.sums), "{configuration}, {name}");
                if accelerator != Accelerator::Bvh {
                    // A walk through a tree enters fewer boxes if hits are found in the meantime.
                    assert_eq!(both(few.sums), both(whole.sums), "{configuration}, {name}");
                }
                if accelerator == Accelerator::None {
                    // Every ray tests every triangle, in each sample.
                    assert_eq!(few.sums.triangles_tested, 2 * 1000 * 256, "{configuration}, {name}");
                    let most = walks.map(|(counted, _)| counted.triangles_tested).max();
                    assert!(most < Some(1000 * 256 / 2), "{configuration}, {name}: {most:?} in one pass");
                }
            }
        }
    }
}
