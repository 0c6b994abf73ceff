//! A run can be stopped at any pass, read in part, moved between threads, and restored to an earlier pass.

mod alone;
mod traces;
mod view;

use std::ops::ControlFlow;

use raystep_kernels::export::trace::ray_state;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::tables::state::StateCounts;
use raystep_kernels::{
    Accelerator, Device, Options, PassTotals, Region, RenderError, Renderer, Samples, ScheduleKind, StreamData,
};
use raystep_tests::configurations::{Configuration, STEPPED, stepped};
use raystep_tests::{block_on, devices, gpu_of, options, scene, streams_of};

const CONFIGURATIONS: [Configuration; 5] = [
    STEPPED,
    Configuration::new(Accelerator::Grid, ScheduleKind::First, 1),
    Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 1),
    Configuration::new(Accelerator::Bvh, ScheduleKind::Compact, 1),
    Configuration::new(Accelerator::None, ScheduleKind::Compact, 2),
];

async fn all(renderer: &Renderer) -> Vec<StreamData> {
    let mut all = Vec::new();
    for stream in streams_of(renderer.plan()) {
        all.push(renderer.values(stream).await.expect("values"));
    }
    all
}

/// What must be equal in two runs: everything except times.
fn books(renderer: &Renderer) -> Vec<(raystep_kernels::Kernel, u32, u32, StateCounts, u64)> {
    renderer.passes().iter().map(|p| (p.kernel, p.iteration, p.rays_in, p.counts.clone(), p.threads_launched)).collect()
}

/// A run without records has the same totals as one with them, but not the single passes.
#[test]
fn a_run_that_keeps_no_passes_sums_them_up_all_the_same() {
    let scene = scene("cornell-box.gltf");
    // Times, and therefore their sums, differ from run to run.
    fn counts(totals: &PassTotals) -> PassTotals {
        let mut totals = totals.clone();
        totals.duration_ns = None;
        totals.kernels.values_mut().for_each(|kernel| kernel.duration_ns = None);
        totals
    }
    for (name, device) in devices() {
        for (configuration, count) in
            CONFIGURATIONS.into_iter().flat_map(|configuration| [(configuration, 1), (configuration, 3)])
        {
            let samples = Samples { count, ..Samples::default() };
            let kept = Options { samples, ..configuration.of(&options(&scene, 12, 10)) };
            let summed = Options { keep_passes: false, ..kept.clone() };
            block_on(gpu_of(&device), async {
                let mut with = Renderer::new(&scene, &kept, &device).await.expect("a renderer");
                let mut without = Renderer::new(&scene, &summed, &device).await.expect("a renderer");
                with.run(|_| ControlFlow::Continue(())).await.expect("a run");
                let totals: PassTotals = with.passes().iter().collect();
                assert_eq!(&totals, with.totals(), "{name} {configuration}");
                assert_eq!(totals.rays_in(), Some(with.passes().iter().map(|p| u64::from(p.rays_in)).sum()));

                without.run_to(5, |_| ControlFlow::Continue(())).await.expect("passes");
                let (early, place) = (without.checkpoint().await.expect("a checkpoint"), without.totals().clone());
                assert_eq!((without.pass_count(), early.place()), (5, 5), "{name} {configuration}");
                without.run(|_| ControlFlow::Continue(())).await.expect("a run");
                assert_eq!(counts(without.totals()), counts(&totals), "{name} {configuration}");
                assert_eq!(without.pass_count(), with.pass_count(), "{name} {configuration}");
                assert_eq!(
                    without.last_pass().map(|p| (p.index, p.kernel, p.counts.clone())),
                    with.passes().last().map(|p| (p.index, p.kernel, p.counts.clone())),
                    "{name} {configuration}"
                );
                assert!(without.passes().is_empty(), "{name} {configuration}: records were not requested");
                assert!(all(&without).await == all(&with).await, "{name} {configuration}");
                without.restore(&early).expect("the same run");
                assert_eq!((without.totals(), without.pass_count()), (&place, 5), "{name} {configuration}");
                without.restart();
                assert_eq!(without.totals(), &PassTotals::default(), "{name} {configuration}");
            });
        }
    }
}

#[test]
fn a_run_stops_where_it_is_told_to_and_never_later() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        for configuration in CONFIGURATIONS {
            let options = configuration.of(&options(&scene, 24, 20));
            block_on(gpu_of(&device), async {
                let mut one_by_one = Renderer::new(&scene, &options, &device).await.expect("a renderer");
                let (plan, data) = (one_by_one.shared_plan(), one_by_one.shared_data());
                let mut at_once = Renderer::from_plan(plan, data, &options, &device).await.expect("a renderer");
                assert!(std::ptr::eq(one_by_one.data(), at_once.data()), "the scene is shared");
                for place in [1, 2, 3, 7, 8, 30] {
                    while one_by_one.pass_count() < place && one_by_one.step().await.expect("a pass").is_some() {}
                    let place = one_by_one.pass_count();
                    at_once.run_to(place, |_| ControlFlow::Continue(())).await.expect("passes");
                    assert_eq!(at_once.pass_count(), place, "{name} {configuration}");
                    assert_eq!(books(&at_once), books(&one_by_one), "{name} {configuration} after {place} passes");
                    assert!(
                        all(&at_once).await == all(&one_by_one).await,
                        "{name} {configuration} after {place} passes"
                    );
                }
                at_once.restart();
                let mut stopped = at_once.run_to(usize::MAX, |_| ControlFlow::Break(())).await;
                let place = at_once.pass_count();
                assert!(
                    matches!(stopped, Err(RenderError::Cancelled { passes }) if passes == place),
                    "{name} {configuration}: {stopped:?}"
                );
                stopped = at_once.run_to(usize::MAX, |_| ControlFlow::Continue(())).await;
                assert!(stopped.is_ok() && at_once.next_kernel().is_none());
            });
        }
    }
}

#[test]
fn a_part_of_a_stream_is_that_part() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        block_on(gpu_of(&device), async {
            let options = STEPPED.of(&options(&scene, 70, 9));
            let mut renderer = Renderer::new(&scene, &options, &device).await.expect("a renderer");
            renderer.run_to(12, |_| ControlFlow::Continue(())).await.expect("passes");
            let streams = streams_of(renderer.plan());
            let texels = renderer.texels(&streams, 65, 7).await.expect("texels");
            let region = Region { x: 63, y: 2, width: 7, height: 6 };
            for (stream, texel) in streams.into_iter().zip(texels) {
                let whole = renderer.values(stream).await.expect("values");
                let expected: Vec<u32> = (0..stream.layers()).map(|l| whole.get(l, 7 * 70 + 65)).collect();
                assert_eq!(texel, expected, "{name} {}", stream.name());
                let part = renderer.region(stream, region).await.expect("a part");
                assert_eq!((part.width, part.height), (7, 6));
                for layer in 0..stream.layers() {
                    for (i, &bits) in part.layer(layer).iter().enumerate() {
                        let at = (2 + i / 7) * 70 + 63 + i % 7;
                        assert_eq!(bits, whole.get(layer, at), "{name} {} {layer} {i}", stream.name());
                    }
                }
            }
            let beside = renderer.region(streams::STATE, Region { x: 64, ..region }).await;
            assert!(matches!(beside, Err(RenderError::NoPixel { .. })), "{beside:?}");
            let left_out = renderer.texels(&[streams::STATE, streams::COUNTERS], 0, 0).await;
            assert!(matches!(left_out, Err(RenderError::NoStream("counters"))), "{left_out:?}");
            let ray = ray_state(&renderer, 65, 7).await.expect("a ray");
            assert!(ray.tmax[0].is_some() && ray.direction != [0.0; 3]);
        });
    }
}

#[test]
fn a_future_of_a_run_can_go_to_another_thread() {
    fn can_move<T: Send>(value: T) -> T {
        value
    }
    let scene = scene("cornell-box.gltf");
    let options = stepped(&scene, 8, 8);
    let device = Device::Cpu(None);
    block_on(None, async {
        let mut renderer = can_move(Renderer::new(&scene, &options, &device)).await.expect("a renderer");
        can_move(renderer.run_to(9, |_| ControlFlow::Continue(()))).await.expect("passes");
        can_move(ray_state(&renderer, 4, 4)).await.expect("a ray");
        let kept = can_move(renderer.checkpoint()).await.expect("a checkpoint");
        can_move(renderer.values(streams::HIT)).await.expect("values");
        renderer.restore(&can_move(kept)).expect("the same run");
    });
}

#[test]
fn after_a_checkpoint_the_same_passes_follow() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        for configuration in CONFIGURATIONS {
            let options = configuration.of(&options(&scene, 24, 20));
            block_on(gpu_of(&device), async {
                let go_on = |_: &raystep_kernels::Progress| ControlFlow::Continue(());
                let mut renderer = Renderer::new(&scene, &options, &device).await.expect("a renderer");
                let (mut kept, mut seen) = (Vec::new(), Vec::new());
                loop {
                    seen.push((all(&renderer).await, renderer.live().clone()));
                    if [0, 1, 2, 5, 12, 13].contains(&renderer.pass_count()) {
                        kept.push(renderer.checkpoint().await.expect("a checkpoint"));
                    }
                    if renderer.step().await.expect("a pass").is_none() {
                        break;
                    }
                }
                let passes = books(&renderer);
                // In any order, forwards and back.
                for i in [5, 0, 3, 4, 1, 2, 2] {
                    let place = kept[i].place();
                    renderer.restore(&kept[i]).expect("the same run");
                    assert_eq!(renderer.pass_count(), place);
                    for at in [place, place + 1, place + 4].map(|at| at.min(passes.len())) {
                        renderer.run_to(at, go_on).await.expect("passes");
                        assert!(all(&renderer).await == seen[at].0, "{name} {configuration}: {at} from {place}");
                        assert_eq!(*renderer.live(), seen[at].1);
                    }
                    renderer.run(go_on).await.expect("passes");
                    assert_eq!(books(&renderer), passes, "{name} {configuration} from {place}");
                    assert!(all(&renderer).await == seen[passes.len()].0, "{name} {configuration} from {place}");
                }
                // What a pass does not change is not stored again.
                let bytes: u64 = kept.iter().map(raystep_kernels::Checkpoint::bytes).sum();
                let together = raystep_kernels::Checkpoint::bytes_of(&kept);
                assert!(together <= bytes && together >= kept[0].bytes());
                if name == "gpu" {
                    assert!(together < bytes * 9 / 10, "{together} of {bytes}");
                }
                let mut other = Renderer::new(&scene, &options, &device).await.expect("a renderer");
                assert!(matches!(other.restore(&kept[0]), Err(RenderError::OtherRun)));
            });
        }
    }
}
