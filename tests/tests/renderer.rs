//! A run can be stopped at any pass, looked at in part, shared with others, and brought back to where it was.

use std::ops::ControlFlow;

use raystep_kernels::export::trace::{Rays, Trace, TraceRow, ray_state, trace};
use raystep_kernels::{
    Accelerator, Device, Numerics, Options, PassTotals, Ray, RaySource, Region, RenderError, Renderer, Samples,
    ScheduleKind, Stream, StreamData, state::STATES,
};
use raystep_scenes::Scene;
use raystep_tests::ways::{STEPPED, Way, stepped};
use raystep_tests::{block_on, camera, devices, gpu_of, options, rays, scene, scene_files, streams_of, words};

const WAYS: [Way; 5] = [
    STEPPED,
    Way::new(Accelerator::Grid, ScheduleKind::First, 1),
    Way::new(Accelerator::Grid, ScheduleKind::Compact, 1),
    Way::new(Accelerator::Bvh, ScheduleKind::Compact, 1),
    Way::new(Accelerator::None, ScheduleKind::Compact, 2),
];

async fn all(renderer: &Renderer) -> Vec<StreamData> {
    let mut all = Vec::new();
    for stream in streams_of(renderer.plan()) {
        all.push(renderer.values(stream).await.expect("values"));
    }
    all
}

/// What must be the same in two runs: all but the times.
fn books(renderer: &Renderer) -> Vec<(raystep_kernels::Kernel, u32, u32, [u32; STATES.len()], u64)> {
    renderer.passes().iter().map(|p| (p.kernel, p.iteration, p.rays_in, p.counts, p.threads_launched)).collect()
}

/// Without records a run knows what it knows with them, but each single pass.
#[test]
fn a_run_that_keeps_no_passes_sums_them_up_all_the_same() {
    let scene = scene("cornell-box.gltf");
    // Times differ from run to run, and sums of them with it.
    fn counts(totals: &PassTotals) -> (usize, u64, Vec<(&'static str, usize, u64)>) {
        let kernels = totals.kernels.iter().map(|(&name, kernel)| (name, kernel.passes, kernel.rays_in));
        (totals.passes, totals.threads_launched, kernels.collect())
    }
    for (name, device) in devices() {
        for (way, count) in WAYS.into_iter().flat_map(|way| [(way, 1), (way, 3)]) {
            let samples = Samples { count, ..Samples::default() };
            let kept = Options { samples, ..way.of(&options(&scene, 12, 10)) };
            let summed = Options { keep_passes: false, ..kept.clone() };
            block_on(gpu_of(&device), async {
                let mut with = Renderer::new(&scene, &kept, &device).await.expect("a renderer");
                let mut without = Renderer::new(&scene, &summed, &device).await.expect("a renderer");
                with.run(|_| ControlFlow::Continue(())).await.expect("a run");
                let totals: PassTotals = with.passes().iter().collect();
                assert_eq!(&totals, with.totals(), "{name} {way}");
                assert_eq!(totals.rays_in(), with.passes().iter().map(|p| u64::from(p.rays_in)).sum::<u64>());

                without.run_to(5, |_| ControlFlow::Continue(())).await.expect("passes");
                let (early, place) = (without.checkpoint().await.expect("a checkpoint"), without.totals().clone());
                assert_eq!((without.pass_count(), early.place()), (5, 5), "{name} {way}");
                without.run(|_| ControlFlow::Continue(())).await.expect("a run");
                assert_eq!(counts(without.totals()), counts(&totals), "{name} {way}");
                assert_eq!(without.pass_count(), with.pass_count(), "{name} {way}");
                assert_eq!(
                    without.last_pass().map(|p| (p.index, p.kernel, p.counts)),
                    with.passes().last().map(|p| (p.index, p.kernel, p.counts)),
                    "{name} {way}"
                );
                assert!(without.passes().is_empty(), "{name} {way}: nobody asked for them");
                assert!(all(&without).await == all(&with).await, "{name} {way}");
                without.restore(&early).expect("the same run");
                assert_eq!((without.totals(), without.pass_count()), (&place, 5), "{name} {way}");
                without.restart();
                assert_eq!(without.totals(), &PassTotals::default(), "{name} {way}");
            });
        }
    }
}

#[test]
fn a_run_stops_where_it_is_told_to_and_never_later() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        for way in WAYS {
            let options = way.of(&options(&scene, 24, 20));
            block_on(gpu_of(&device), async {
                let mut one_by_one = Renderer::new(&scene, &options, &device).await.expect("a renderer");
                let (plan, data) = (one_by_one.shared_plan(), one_by_one.shared_data());
                let mut at_once = Renderer::from_plan(plan, data, &options, &device).await.expect("a renderer");
                assert!(std::ptr::eq(one_by_one.data(), at_once.data()), "the scene is there once");
                for place in [1, 2, 3, 7, 8, 30] {
                    while one_by_one.pass_count() < place && one_by_one.step().await.expect("a pass").is_some() {}
                    let place = one_by_one.pass_count();
                    at_once.run_to(place, |_| ControlFlow::Continue(())).await.expect("passes");
                    assert_eq!(at_once.pass_count(), place, "{name} {way}");
                    assert_eq!(books(&at_once), books(&one_by_one), "{name} {way} after {place} passes");
                    assert!(all(&at_once).await == all(&one_by_one).await, "{name} {way} after {place} passes");
                }
                at_once.restart();
                let mut stopped = at_once.run_to(usize::MAX, |_| ControlFlow::Break(())).await;
                let place = at_once.pass_count();
                assert!(
                    matches!(stopped, Err(RenderError::Cancelled { passes }) if passes == place),
                    "{name} {way}: {stopped:?}"
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
            let beside = renderer.region(Stream::State, Region { x: 64, ..region }).await;
            assert!(matches!(beside, Err(RenderError::NoPixel { .. })), "{beside:?}");
            let left_out = renderer.texels(&[Stream::State, Stream::Counters], 0, 0).await;
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
        can_move(renderer.values(Stream::Hit)).await.expect("values");
        renderer.restore(&can_move(kept)).expect("the same run");
    });
}

#[test]
fn after_a_checkpoint_the_same_passes_follow() {
    let scene = scene("cornell-box.gltf");
    for (name, device) in devices() {
        for way in WAYS {
            let options = way.of(&options(&scene, 24, 20));
            block_on(gpu_of(&device), async {
                let go_on = |_: &raystep_kernels::Progress| ControlFlow::Continue(());
                let mut renderer = Renderer::new(&scene, &options, &device).await.expect("a renderer");
                let (mut kept, mut seen) = (Vec::new(), Vec::new());
                loop {
                    seen.push((all(&renderer).await, renderer.live()));
                    if [0, 1, 2, 5, 12, 13].contains(&renderer.pass_count()) {
                        kept.push(renderer.checkpoint().await.expect("a checkpoint"));
                    }
                    if renderer.step().await.expect("a pass").is_none() {
                        break;
                    }
                }
                let passes = books(&renderer);
                // In any order, forward and back.
                for i in [5, 0, 3, 4, 1, 2, 2] {
                    let place = kept[i].place();
                    renderer.restore(&kept[i]).expect("the same run");
                    assert_eq!(renderer.pass_count(), place);
                    for at in [place, place + 1, place + 4].map(|at| at.min(passes.len())) {
                        renderer.run_to(at, go_on).await.expect("passes");
                        assert!(all(&renderer).await == seen[at].0, "{name} {way}: {at} from {place}");
                        assert_eq!(renderer.live(), seen[at].1);
                    }
                    renderer.run(go_on).await.expect("passes");
                    assert_eq!(books(&renderer), passes, "{name} {way} from {place}");
                    assert!(all(&renderer).await == seen[passes.len()].0, "{name} {way} from {place}");
                }
                // What a pass does not change is not kept again.
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

/// Where rays come from, whether any hit ends them, and which of them to follow: a spread over the picture, and rays
/// in turn from inside of the scene, from outside and from its surface.
fn followed(scene: &Scene) -> Vec<(RaySource, bool, Vec<[u32; 2]>)> {
    let camera = RaySource::Camera { camera: camera(scene), width: 64, height: 48 };
    let pixels = vec![[32, 24], [20, 30], [45, 17], [11, 40], [52, 36], [3, 3]];
    if scene.triangles.is_empty() {
        return vec![(camera, false, pixels)];
    }
    let random = RaySource::Given(rays::random(scene, 24, 5));
    let nine = || (0..9).map(|i| [i, 0]).collect();
    vec![(camera, false, pixels), (random.clone(), false, nine()), (random, true, nine())]
}

/// A triangle too small for the paper's threshold beside one of the scene's size, and a ray that meets it.
fn small_triangle() -> (Scene, RaySource) {
    let mut scene = scene("single-triangle.gltf");
    let [a, b, c] = scene.triangles[0].map(glam::Vec3::from);
    let [u, v] = [(b - a) / 2000.0, (c - a) / 2000.0];
    scene.triangles.push([a, a + u, a + v].map(|corner| corner.to_array()));
    scene.triangle_materials.push(0);
    (scene.normals, scene.texcoords, scene.colors) = (None, None, None);
    let normal = u.cross(v).normalize();
    let origin = a + (u + v) * 0.25 + normal;
    (scene, RaySource::Given(vec![Ray { origin: origin.to_array(), direction: (-normal).to_array() }]))
}

async fn life(renderer: &mut Renderer, [x, y]: [u32; 2], rays: Rays) -> Trace {
    trace(renderer, x, y, rays, |_| ControlFlow::Continue(())).await.expect("a trace")
}

#[test]
fn the_words_of_every_pass_say_what_the_streams_say() {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, Second};
    let ways = [
        Way::new(Grid, Second, 1),
        Way::new(Grid, Compact, 1).leaping(),
        Way::new(Grid, Compact, 8).leaping(),
        Way::new(Grid, Compact, 8),
        Way::new(Grid, Second, 1).paper(),
        Way::new(Bvh, Compact, 1),
        Way::new(Bvh, Compact, 2),
        Way::new(None, Second, 1),
        Way::new(None, Compact, 8),
        Way::new(None, Second, 1).paper(),
    ];
    let mut seen = std::collections::BTreeMap::<&str, usize>::new();
    let mut hear = |label: &str, scene: &Scene, options: &Options, device: &Device, rays: &[[u32; 2]]| {
        block_on(gpu_of(device), async {
            let mut renderer = Renderer::new(scene, options, device).await.expect("a renderer");
            for &ray in rays {
                let life = life(&mut renderer, ray, Rays::One).await;
                let kinds = words::check(&life, renderer.data());
                for kind in kinds.unwrap_or_else(|why| panic!("{label}, ray {ray:?}: {why}")) {
                    *seen.entry(kind).or_default() += 1;
                }
            }
        });
    };
    for file in scene_files() {
        let scene = scene(&file);
        for way in ways.iter().filter(|way| way.accelerator != None || scene.triangles.len() <= 200) {
            for (source, any_hit, rays) in followed(&scene) {
                let is_camera = matches!(source, RaySource::Camera { .. });
                if any_hit && way.numerics == Numerics::Paper {
                    continue;
                }
                let options = Options { shade: is_camera, any_hit, ..way.of(&Options::new(source)) };
                // On the adapter the words are of what it did, with the host's own functions beside.
                let on_adapter = is_camera && way.steps == 1 && file == "teapot.glb";
                for (name, device) in devices().into_iter().filter(|(name, _)| *name == "cpu" || on_adapter) {
                    hear(&format!("{file} {name} {way}"), &scene, &options, &device, &rays);
                }
            }
        }
    }
    let (scene, source) = small_triangle();
    let options = Options { shade: false, ..Way::new(None, Second, 1).paper().of(&Options::new(source)) };
    hear("a small triangle", &scene, &options, &Device::Cpu(Option::None), &[[0, 0]]);
    println!("{seen:?}");
    let all = [
        "generated",
        "started",
        "starts inside",
        "misses the grid",
        "starts outside",
        "steps",
        "steps out",
        "leaps",
        "leaps out",
        "wraps",
        "empty cell",
        "list ended",
        "kept",
        "accepted",
        "accepted in its cell",
        "hit",
        "not nearer",
        "again",
        "outside",
        "outside of the cell",
        "behind",
        "edge-on",
        "small determinant",
        "box met",
        "box missed",
        "node done",
        "leaf",
        "leaf done",
        "down",
        "up",
        "sibling",
        "tree done",
        "last accepted",
        "last missed",
        "no triangles",
        "walk goes on",
        "walk found",
        "walk hit",
        "walk missed",
        "any hit",
        "ray ended",
        "beyond the end",
        "shaded",
        "background",
    ];
    let unseen: Vec<_> = all.into_iter().filter(|kind| !seen.contains_key(kind)).collect();
    assert!(unseen.is_empty(), "no ray had its words say: {unseen:?}");
}

#[test]
fn a_ray_alone_does_what_it_does_beside_all_others() {
    use Accelerator::{Bvh, Grid, None};
    use ScheduleKind::{Compact, First, Second};
    let ways = [
        Way::new(Grid, Compact, 1).leaping(),
        Way::new(Grid, Second, 1),
        Way::new(Grid, Compact, 8),
        Way::new(Grid, Second, 1).paper(),
        Way::new(Bvh, Second, 1),
        Way::new(Bvh, Compact, 1),
        Way::new(None, Compact, 4),
        Way::new(None, First, 1),
    ];
    for file in scene_files() {
        let scene = scene(&file);
        for way in ways.iter().filter(|way| way.accelerator != None || scene.triangles.len() <= 200) {
            let on_adapter = ["cornell-box.gltf", "flat.gltf"].contains(&file.as_str());
            for (name, device) in devices().into_iter().filter(|(name, _)| *name == "cpu" || on_adapter) {
                let options = way.of(&options(&scene, 22, 17));
                block_on(gpu_of(&device), async {
                    let mut renderer = Renderer::new(&scene, &options, &device).await.expect("a renderer");
                    for pixel in [[11, 8], [4, 12], [21, 0]] {
                        let label = format!("{file} {name} {way}, ray {pixel:?}");
                        let whole = life(&mut renderer, pixel, Rays::All).await;
                        let alone = life(&mut renderer, pixel, Rays::One).await;
                        let others = renderer.passes().iter().filter(|p| p.rays_in > 1).count();
                        assert_eq!((others, alone.rays, alone.passes), (0, 1, Option::None), "{label}");
                        assert_eq!((whole.rays, whole.rows.len()), (22 * 17, alone.rows.len()), "{label}");
                        let last = whole.passes.map(|passes| passes - 1);
                        for (alone, whole) in alone.rows.iter().zip(&whole.rows) {
                            // Debug prints every float so that it reads back as the same bits.
                            let expected = if alone.kernel == "shade" { last } else { alone.pass };
                            assert_eq!(whole.pass, expected, "{label}");
                            let alone = TraceRow { pass: expected, ..alone.clone() };
                            assert_eq!(format!("{alone:?}"), format!("{whole:?}"), "{label}");
                        }
                        assert!(alone.rows.last().is_some_and(|row| row.pass.is_none()), "{label}");
                    }
                    // All rays again, where it is not asked for one.
                    renderer.restart();
                    renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
                    assert_eq!(renderer.live()[raystep_kernels::state::DONE as usize], 22 * 17);
                });
            }
        }
    }
}

#[test]
fn where_a_ray_depends_on_the_others_all_are_traced() {
    let scene = scene("cornell-box.gltf");
    let samples = raystep_kernels::Samples { count: 2, ..Default::default() };
    let of = |way: Way| way.of(&options(&scene, 12, 10));
    let first = of(Way::new(Accelerator::Grid, ScheduleKind::First, 1));
    for options in [first, Options { samples, ..of(STEPPED) }] {
        block_on(None, async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            assert!(!renderer.can_go_alone());
            let [one, all] =
                [life(&mut renderer, [5, 5], Rays::One).await, life(&mut renderer, [5, 5], Rays::All).await];
            assert_eq!((one.rays, one.passes), (120, Some(renderer.passes().len())));
            assert_eq!(one, all);
            words::check(&one, renderer.data()).unwrap_or_else(|why| panic!("{why}"));
        });
    }
}
