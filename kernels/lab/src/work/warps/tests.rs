use raystep_kernels::programs::closest_hit::states::{DONE, ISECT_NO_HIT, SHADE, TRAV, TRAV_SETUP};
use raystep_kernels::programs::closest_hit::{PROGRAM, kernels, streams};
use raystep_kernels::{Accelerator, Device, Limits, Options, RaySource, Renderer, ScheduleKind};
use raystep_scenes::generate;

use super::*;

fn options(schedule: ScheduleKind, [width, height]: [u32; 2]) -> Options {
    let camera = generate::cornell_box().cameras[0].clone();
    Options { schedule, steps_per_pass: 1, ..Options::new(RaySource::Camera { camera, width, height }) }
}

fn planned(schedule: ScheduleKind, size: [u32; 2]) -> Plan {
    Plan::new(&generate::cornell_box(), &options(schedule, size), &Limits::CPU).expect("a small scene").0
}

/// What the WGSL says of its threads is what is assumed here.
#[test]
fn the_kernels_compute_their_texels_as_assumed() {
    for kernel in PROGRAM.kernels().filter(|kernel| kernel.role() != Role::Count) {
        let wgsl = kernel.info().wgsl;
        assert_eq!(wgsl.contains("tiled_texel(group, lane)"), is_tiled(kernel), "{}", kernel.name());
        let is_plain = wgsl.contains("texel = id.xy") || wgsl.contains("vec2u(id.x, id.y");
        assert!(is_plain || is_tiled(kernel) || kernel.role() == Role::Walk, "{}", kernel.name());
    }
}

#[test]
fn every_pixel_has_one_thread_and_threads_lie_as_in_their_workgroups() {
    let size = [40, 20];
    for kernel in [kernels::SETUP, kernels::INTERSECT, kernels::SHADE] {
        let mut rays: Vec<u32> = threads(kernel, size).into_iter().filter(|&ray| ray != NO_RAY).collect();
        rays.sort_unstable();
        assert!(rays.iter().copied().eq(0..800), "{}", kernel.name());
    }
    // Of 32 threads: two rows of 16 pixels, or a tile of 8 by 4.
    let at = |kernel, thread: usize| threads(kernel, size)[thread];
    assert_eq!((at(kernels::INTERSECT, 15), at(kernels::INTERSECT, 16), at(kernels::INTERSECT, 31)), (15, 40, 55));
    assert_eq!((at(kernels::SETUP, 7), at(kernels::SETUP, 8), at(kernels::SETUP, 32)), (7, 40, 8));
    assert_eq!((at(kernels::SHADE, 8), at(kernels::SHADE, 64)), (40, 8));
}

#[test]
fn a_warp_lasts_as_long_as_its_longest_walk() {
    let plan = planned(ScheduleKind::Second, [16, 16]);
    let mut survey = Survey::new(&plan, 32).expect("rays");
    // Of the first warp, ray 3 is tested three times, ray 17 twice, ray 40 (another warp) once.
    let mut tags = vec![DONE; 256];
    for (pass, live) in [&[3, 17, 40][..], &[3, 17], &[3]].into_iter().enumerate() {
        tags.fill(DONE);
        live.iter().for_each(|&ray: &usize| tags[ray] = ISECT_NO_HIT);
        survey.add(kernels::INTERSECT, &tags, &tags, None);
        assert_eq!(survey.passes()[pass].working, live.len() as u64);
    }
    let lanes: Vec<_> = survey.passes().iter().map(|pass| (pass.busy, pass.warps, pass.useful(32))).collect();
    assert_eq!(lanes, [(2, 8, 3.0 / 64.0), (1, 8, 2.0 / 32.0), (1, 8, 1.0 / 32.0)]);
    let warps = survey.slowest(10);
    assert_eq!(warps.len(), 2, "the others had no work");
    let first = &warps[0];
    assert_eq!((first.passes, first.sparse, first.slowest, first.slowest_passes, first.median_passes), (3, 3, 3, 3, 0));
    assert_eq!((first.useful, first.rays.len()), (5.0 / 96.0, 32));
    assert_eq!((warps[1].passes, warps[1].slowest), (1, 40));
    assert_eq!(survey.slowest(1).len(), 1);
    assert_eq!(survey.passes_of_rays()[17], 2);
}

#[test]
fn lists_keep_the_order_of_the_threads_that_append_to_them() {
    let plan = planned(ScheduleKind::Compact, [16, 16]);
    let mut survey = Survey::new(&plan, 8).expect("rays");
    let (mut before, mut after) = (vec![TRAV_SETUP; 256], vec![SHADE; 256]);
    // Threads of set-up lie in tiles: ray 16, in the second row, comes before ray 8.
    for ray in [0, 8, 16] {
        after[ray] = ISECT_NO_HIT;
    }
    survey.add(kernels::SETUP, &before, &after, None);
    assert_eq!(survey.lists[0], [0, 16, 8]);
    before.clone_from(&after);
    (after[0], after[16]) = (TRAV, SHADE);
    survey.add(kernels::INTERSECT, &before, &after, None);
    assert_eq!((&survey.lists[0][..], &survey.lists[1][..]), (&[8][..], &[0][..]));
    let pass = survey.passes()[1];
    assert_eq!((pass.launch, pass.working, pass.busy, pass.warps), (Launch::List, 3, 1, 256));
    before.clone_from(&after);
    after[0] = ISECT_NO_HIT;
    survey.add(kernels::TRAVERSE_GRID, &before, &after, None);
    assert_eq!(survey.lists[0], [8, 0], "appended to those that wait already");
}

/// With several steps, a warp turns as often as its longest loop.
#[test]
fn lanes_wait_for_the_longest_loop() {
    let options = Options { steps_per_pass: 8, ..options(ScheduleKind::Compact, [16, 16]) };
    let (plan, _) = Plan::new(&generate::cornell_box(), &options, &Limits::CPU).expect("a small scene");
    let mut survey = Survey::new(&plan, 32).expect("rays");
    let mut turns = vec![0; 256];
    (turns[0], turns[1]) = (8, 2);
    let mut tags = vec![DONE; 256];
    (tags[0], tags[1]) = (ISECT_NO_HIT, TRAV);
    survey.lists[0] = vec![0, 1];
    survey.add(kernels::WALK, &tags, &tags, Some(&turns));
    assert_eq!(survey.passes()[0].turns, Some([10, 8 * 32]));
}

/// A whole run, by every structure and schedule with steps: each pass has as many working lanes as it has rays.
#[test]
fn the_lanes_of_a_run_are_those_that_its_passes_worked_on() {
    let structures = [Accelerator::Grid, Accelerator::Bvh, Accelerator::None];
    for schedule in [ScheduleKind::First, ScheduleKind::Second, ScheduleKind::Compact] {
        for accelerator in structures {
            let options = Options { accelerator, keep_passes: true, ..options(schedule, [24, 20]) };
            pollster::block_on(async {
                let scene = generate::cornell_box();
                let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
                let mut survey = Survey::new(renderer.plan(), 32).expect("rays");
                let mut before = renderer.values(streams::STATE).await.expect("state").layer(0).to_vec();
                while let Some(pass) = renderer.step().await.expect("a pass") {
                    let after = renderer.values(streams::STATE).await.expect("state").layer(0).to_vec();
                    survey.add(pass.kernel, &before, &after, None);
                    let lanes = survey.passes().last().expect("a pass");
                    assert_eq!(lanes.working, u64::from(pass.rays_in), "{schedule} {accelerator} {}", pass.index);
                    before = after;
                }
                let all: u32 = survey.passes_of_rays().iter().sum();
                assert_eq!(u64::from(all), renderer.passes().iter().map(|pass| u64::from(pass.rays_in)).sum::<u64>());
                let slowest = survey.slowest(3);
                assert!(slowest.iter().all(|warp| warp.passes >= warp.slowest_passes && warp.useful <= 1.0));
                assert!(slowest.is_sorted_by_key(|warp| std::cmp::Reverse(warp.passes)));
            });
        }
    }
}
