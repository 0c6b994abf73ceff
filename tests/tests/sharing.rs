//! Streams that share textures: a device may allow fewer storage textures than a kernel writes streams.

use std::ops::ControlFlow;

use raystep_kernels::options::ProgramName;
use raystep_kernels::options::scene_data::SceneDataKind;
use raystep_kernels::plan::Sharing;
use raystep_kernels::{
    Accelerator, Device, Limits, Options, Plan, PlanError, Renderer, Samples, ScheduleKind, Stream, StreamData,
};
use raystep_tests::{block_on, differences, gpu, options, scene, streams_of};

const STRUCTURES: [Accelerator; 4] = [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None];

/// What a device has that binds so many storage textures.
fn few(most: u32) -> Limits {
    Limits { storage_textures: most, ..Device::Gpu(gpu()).limits() }
}

async fn renderer(options: &Options, limits: &Limits) -> Renderer {
    let (plan, data) = Plan::new(&scene("cornell-box.gltf"), options, limits).expect("a plan");
    Renderer::from_plan(plan, data, options, &Device::Gpu(gpu())).await.expect("a run")
}

async fn values(renderer: &Renderer) -> Vec<(Stream, StreamData)> {
    let mut all = Vec::new();
    for stream in streams_of(renderer.plan()) {
        if renderer.size(stream.info().elements).is_some() {
            all.push((stream, renderer.values(stream).await.expect("values")));
        }
    }
    all
}

fn assert_same(wanted: &[(Stream, StreamData)], found: &[(Stream, StreamData)], which: &str) {
    assert_eq!(wanted.len(), found.len(), "{which}");
    for ((stream, wanted), (_, found)) in wanted.iter().zip(found) {
        assert_eq!(differences(wanted, found).next(), None, "{which}: {stream:?}");
    }
}

/// Runs passes with a texture for each stream and with shared ones, side by side, and goes back once.
fn compare(options: &Options, most: u32) -> Sharing {
    let which = format!("{} {} {} {most}", options.program, options.accelerator, options.schedule);
    block_on(Some(&gpu()), async {
        let mut own = renderer(options, &few(u32::MAX)).await;
        let mut shared = renderer(options, &few(most)).await;
        assert!(own.plan().sharing.groups.is_empty());
        let (mut kept, mut passes) = (None, 0);
        loop {
            let pass = own.step().await.expect("a pass");
            let of_shared = shared.step().await.expect("a pass");
            let what = |pass: &raystep_kernels::Pass| (pass.kernel, pass.rays_in, pass.counts.clone());
            assert_eq!(pass.as_ref().map(what), of_shared.as_ref().map(what), "{which}: pass {passes}");
            if pass.is_none() {
                break;
            }
            let wanted = values(&own).await;
            assert_same(&wanted, &values(&shared).await, &format!("{which}: pass {passes}"));
            passes += 1;
            if passes == 5 {
                kept = Some((shared.checkpoint().await.expect("a checkpoint"), wanted));
            }
        }
        if let Some((checkpoint, wanted)) = kept {
            shared.restore(&checkpoint).expect("the checkpoint");
            assert_same(&wanted, &values(&shared).await, &format!("{which}: back"));
            let end = values(&own).await;
            shared.run(|_| ControlFlow::Continue(())).await.expect("passes");
            assert_same(&end, &values(&shared).await, &format!("{which}: again"));
        }
        shared.plan().sharing.clone()
    })
}

#[test]
fn streams_in_a_shared_texture_have_the_bits_of_those_in_their_own() {
    let mut most_shared = 0;
    for accelerator in STRUCTURES {
        for &schedule in ScheduleKind::ALL {
            let base = options(&scene("cornell-box.gltf"), 20, 16);
            let options = Options { accelerator, schedule, counters: true, ..base };
            let sharing = compare(&options, 2);
            // Every schedule has a kernel that writes more.
            assert!(!sharing.groups.is_empty(), "{accelerator} {schedule}");
            most_shared = most_shared.max(sharing.groups.iter().map(Vec::len).max().unwrap_or(0));
        }
    }
    assert!(most_shared > 2, "{most_shared} streams in a texture");
}

/// Means of samples, in blocks, are written by a kernel of their own.
#[test]
fn samples_and_sets_that_a_build_finds_share_textures_too() {
    let base = options(&scene("cornell-box.gltf"), 20, 16);
    let samples = Samples { count: 66, ..Samples::default() };
    let sampled = Options { samples, schedule: ScheduleKind::Fused, ..base.clone() };
    assert!(!compare(&sampled, 2).groups.is_empty());
    let textured = Options { scene_data: SceneDataKind::Textures, accelerator: Accelerator::Bvh, ..base.clone() };
    assert!(!compare(&textured, 2).groups.is_empty());
    let build = Options { program: ProgramName::GridBuild, accelerator: Accelerator::Grid, ..base };
    assert!(!compare(&build, 3).groups.is_empty());
}

/// What shares no texture: streams of several sets, and those that others are renamed to.
#[test]
fn a_kernel_whose_streams_cannot_share_is_refused() {
    let base = options(&scene("cornell-box.gltf"), 20, 16);
    let build = Options { program: ProgramName::GridBuild, accelerator: Accelerator::Irregular, ..base };
    let refused = Plan::new(&scene("cornell-box.gltf"), &build, &few(3)).map(|_| ());
    assert!(matches!(refused, Err(PlanError::Bindings { kernel: "make_leaves", .. })), "{refused:?}");
}

/// A component is edited where it is, and its neighbours are not.
#[test]
fn an_edit_reaches_its_own_stream() {
    let options = Options { counters: true, ..options(&scene("cornell-box.gltf"), 20, 16) };
    block_on(Some(&gpu()), async {
        let mut renderer = renderer(&options, &few(2)).await;
        for _ in 0..4 {
            renderer.step().await.expect("a pass");
        }
        let groups = renderer.plan().sharing.groups.clone();
        let stream = *groups[0].last().expect("streams");
        let before = values(&renderer).await;
        renderer.write_component(stream, 0, 3, 2, 77).await.expect("an edit");
        for ((of, before), (_, after)) in before.iter().zip(values(&renderer).await) {
            let found: Vec<_> = differences(before, &after).collect();
            assert_eq!(found.len(), usize::from(*of == stream), "{of:?}: {found:?}");
        }
    });
}

#[test]
fn a_plan_says_which_streams_share_a_texture() {
    let base = options(&scene("cornell-box.gltf"), 20, 16);
    let plan = |limits: &Limits| Plan::new(&scene("cornell-box.gltf"), &base, limits);
    let (few_of_them, _) = plan(&few(2)).expect("a plan");
    let [first, ..] = few_of_them.sharing.groups.as_slice() else { panic!("nothing is shared") };
    let line = format!("  in one texture, as a kernel writes more than the device binds: {}", first[0].name());
    assert!(few_of_them.to_string().contains(&line), "{few_of_them}");
    assert!(matches!(plan(&few(1)), Err(PlanError::Bindings { kind: "storage textures", most: 1, .. })));
    let (core, _) = plan(&few(4)).expect("a plan");
    assert!(core.sharing.groups.is_empty() && !core.to_string().contains("in one texture"));
}
