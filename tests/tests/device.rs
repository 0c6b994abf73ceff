//! Devices with problems: without timers, lost, or too small.

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{
    AdapterChoice, Device, Gpu, GpuError, GridSize, Limits, Options, Plan, PlanError, RenderError, Renderer,
};
use raystep_scenes::generate;
use raystep_tests::configurations::stepped;
use raystep_tests::{block_on, gpu, now_ns, options, scene};

#[test]
fn an_adapter_without_timestamps_leaves_times_empty() {
    let none = wgpu::Features::empty();
    let gpu = pollster::block_on(Gpu::with_features(&AdapterChoice::Best, none)).expect("an adapter");
    assert_eq!(gpu.timestamp_period_ns, None);
    block_on(Some(&gpu), gpu.check_clock(now_ns)).expect("a device");
    assert_eq!((gpu.clock_check(), gpu.clock_period_ns()), (None, None));
    assert!(gpu.why_no_times().is_some_and(|why| why.contains("no timestamps")));
    let scene = scene("cornell-box.gltf");
    let mut options = stepped(&scene, 32, 32);
    options.timings = true;
    block_on(Some(&gpu), async {
        let mut renderer = Renderer::new(&scene, &options, &Device::Gpu(gpu.clone())).await.expect("a renderer");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
        assert!(renderer.pass_count() > 10);
        assert!(renderer.passes().iter().all(|p| p.begin_ns.is_none() && p.duration_ns.is_none()));
        assert!(renderer.host_ns().is_some_and(|ns| ns > 0), "the run has the host's time");
    });
}

#[test]
fn waiting_for_a_device_ends_with_its_work_or_with_the_device() {
    let gpu = a_device_of_its_own();
    block_on(Some(&gpu), gpu.finish()).expect("nothing is left to do");
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("uploaded"),
        size: wgpu::Extent3d { width: 64, height: 64, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Uint,
        usage: wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    gpu.write_texture(texture.as_image_copy(), texture.size(), &[1; 64 * 64 * 4]);
    pollster::block_on(gpu.finish()).expect("a thread polls where no host does");
    gpu.device.destroy();
    assert!(matches!(block_on(Some(&gpu), gpu.finish()), Err(GpuError::Lost(_))));
}

/// Times of a separate run: the number of timed passes, the number of passes, the device's time and the host's.
fn times(gpu: &Arc<Gpu>, options: &Options) -> (usize, usize, Option<u64>, Option<u64>) {
    let scene = scene("cornell-box.gltf");
    block_on(Some(gpu), async {
        let mut renderer = Renderer::new(&scene, options, &Device::Gpu(gpu.clone())).await.expect("a renderer");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
        let timed = renderer.passes().iter().filter(|p| p.duration_ns.is_some_and(|ns| ns > 0)).count();
        (timed, renderer.pass_count(), renderer.device_ns(), renderer.host_ns())
    })
}

/// Passes have times only if the adapter's clock is reliable; the run has the host's time as well.
#[test]
fn passes_have_times_only_where_the_adapters_clock_agrees_with_the_hosts() {
    let gpu = a_device_of_its_own();
    assert!(gpu.timestamp_period_ns.is_some(), "{} has no timestamps", gpu.info.name);
    let scene = scene("cornell-box.gltf");
    let configurations = [stepped(&scene, 256, 256), options(&scene, 256, 256)];
    for options in &configurations {
        let options = Options { timings: true, ..options.clone() };
        let (timed, _, device_ns, host_ns) = times(&gpu, &options);
        assert_eq!((timed, device_ns, host_ns), (0, None, None), "the clocks have not been compared");
    }
    block_on(Some(&gpu), gpu.check_clock(now_ns)).expect("a device");
    let check = gpu.clock_check().expect("a clock");
    eprintln!("{}: {check}", gpu.info.name);
    assert_eq!(gpu.clock_period_ns().is_some(), check.agrees(), "{check}");
    assert_eq!(gpu.why_no_times().is_none(), check.agrees(), "{:?}", gpu.why_no_times());
    for options in configurations {
        let options = Options { timings: true, ..options };
        let (timed, passes, device_ns, host_ns) = times(&gpu, &options);
        let host_ns = host_ns.expect("a host's clock");
        if check.agrees() {
            assert!(timed * 10 >= passes * 9, "{timed} of {passes} passes");
            assert!(device_ns.is_some_and(|ns| ns <= host_ns), "{device_ns:?} of {host_ns} ns");
        } else {
            assert_eq!((timed, device_ns), (0, None), "{check}");
        }
        assert!(host_ns > 0);
    }
}

/// The adapter's clock is compared with the host's clock as it is, ten times faster, and ten times slower: at most one
/// of the three can agree.
#[test]
fn a_clock_that_is_off_by_ten_is_not_taken_for_a_time() {
    type Clock = fn() -> u64;
    let clocks: [(&str, Clock); 3] =
        [("the host's", now_ns), ("ten times as fast", || 10 * now_ns()), ("ten times as slow", || now_ns() / 10)];
    let scene = scene("cornell-box.gltf");
    let options = Options { timings: true, ..options(&scene, 64, 64) };
    let mut agreed = Vec::new();
    for (name, clock) in clocks {
        let gpu = a_device_of_its_own();
        block_on(Some(&gpu), gpu.check_clock(clock)).expect("a device");
        let check = gpu.clock_check().expect("a clock");
        let (timed, _, device_ns, _) = times(&gpu, &options);
        assert_eq!((timed > 0, device_ns.is_some()), (check.agrees(), check.agrees()), "{name}: {check}");
        if check.agrees() {
            agreed.push(name);
        } else {
            let why = gpu.why_no_times().expect("a reason");
            assert!(why.contains("timestamps are wrong") && why.contains("on the host's clock"), "{why}");
        }
    }
    assert!(agreed.len() <= 1, "{agreed:?} all agree");
}

/// A separate device: losing it does not affect other tests, nor do its clock checks.
fn a_device_of_its_own() -> Arc<Gpu> {
    pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter")
}

/// GPU resources are labelled with program and name, for debuggers and wgpu's errors.
#[test]
fn what_is_refused_is_named_after_its_program() {
    let scene = scene("cornell-box.gltf");
    let gpu = a_device_of_its_own();
    block_on(Some(&gpu), async {
        let device = Device::Gpu(gpu.clone());
        let mut renderer = Renderer::new(&scene, &stepped(&scene, 16, 16), &device).await.expect("a renderer");
        renderer.step().await.expect("a pass");
        renderer.texture(streams::TMAX).expect("a stream of this run").texture().destroy();
        let error = loop {
            match renderer.step().await {
                Ok(Some(_)) => {}
                Ok(None) => panic!("a destroyed texture was used"),
                Err(error) => break error.to_string(),
            }
        };
        assert!(error.contains("closest_hit.tmax"), "{error}");
    });
}

#[test]
fn a_lost_device_is_an_error_and_not_a_panic() {
    let scene = scene("cornell-box.gltf");
    let options = stepped(&scene, 64, 64);
    // Lost beforehand, between two passes, and during a read-back.
    let gpu = a_device_of_its_own();
    gpu.device.destroy();
    drop(gpu.device.poll(wgpu::PollType::Poll));
    let built = block_on(Some(&gpu), Renderer::new(&scene, &options, &Device::Gpu(gpu.clone())));
    assert!(matches!(built, Err(RenderError::Gpu(_))), "{:?}", built.err());

    let gpu = a_device_of_its_own();
    block_on(Some(&gpu), async {
        let mut renderer = Renderer::new(&scene, &options, &Device::Gpu(gpu.clone())).await.expect("a renderer");
        for _ in 0..5 {
            renderer.step().await.expect("a pass");
        }
        gpu.device.destroy();
        let step = renderer.step().await;
        assert!(matches!(step, Err(RenderError::Gpu(GpuError::Lost(_)))), "{step:?}");
        let values = renderer.values(streams::STATE).await;
        assert!(matches!(values, Err(RenderError::Gpu(GpuError::Lost(_)))), "{:?}", values.err());
        let message = step.expect_err("lost").to_string();
        assert!(message.contains("lost") && message.contains("--device cpu") && !message.contains('\n'), "{message}");
    });
}

#[test]
fn work_that_is_held_back_waits_until_all_have_let_go() {
    let gpu = a_device_of_its_own();
    let (first, second) = (gpu.hold_back(), gpu.hold_back());
    let (done, is_done) = std::sync::mpsc::channel();
    let other = gpu.clone();
    let worker = std::thread::spawn(move || {
        other.submit([]);
        done.send(())
    });
    // Submitting nothing takes microseconds.
    let short = std::time::Duration::from_millis(200);
    assert!(is_done.recv_timeout(short).is_err(), "it did not wait");
    drop(first);
    assert!(is_done.recv_timeout(short).is_err(), "it waited for only one of the two");
    drop(second);
    is_done.recv_timeout(std::time::Duration::from_secs(60)).expect("it continues once nothing holds it back");
    worker.join().expect("no panic").expect("a listener");
}

#[test]
fn an_unknown_adapter_is_named_beside_those_that_are_there() {
    let error = pollster::block_on(Gpu::new(&AdapterChoice::Named("Voodoo 2".into()))).err().expect("no such adapter");
    let message = error.to_string();
    assert!(message.contains("Voodoo 2") && message.contains(&gpu().info.name), "{message}");
}

#[test]
fn a_buffer_larger_than_the_adapter_binds_is_refused_with_the_numbers() {
    let scene = generate::soup(100_000, 1).expect("soup");
    let limits = Limits { storage_bytes: 3_000_000, ..Limits::CPU };
    let error = Plan::new(&scene, &stepped(&scene, 16, 16), &limits).expect_err("too large");
    assert!(matches!(error, PlanError::BufferSize { name: "vertices", bytes: 3_600_000, limit: 3_000_000 }), "{error}");
    assert_eq!(
        error.to_string(),
        "vertices needs 3.4 MiB in one buffer, but this device binds at most 2.9 MiB: 585.9 KiB too many"
    );
    // A kernel that takes several steps reads triangles in packed form.
    let error = Plan::new(&scene, &options(&scene, 16, 16), &limits).expect_err("too large");
    assert!(matches!(error, PlanError::BufferSize { name: "packed_triangles", bytes: 4_800_000, .. }), "{error}");
    let mut options = stepped(&scene, 16, 16);
    options.grid = GridSize::Cells([200; 3]);
    let limits = Limits { storage_bytes: 3_700_000, ..Limits::CPU };
    let error = Plan::new(&scene, &options, &limits).expect_err("too large");
    assert!(matches!(error, PlanError::BufferSize { name: "grid_cells" | "grid_items", .. }), "{error}");
}

#[test]
fn images_without_pixels_or_with_too_many_are_refused() {
    let scene = scene("cornell-box.gltf");
    let limits = Limits::from(&*gpu());
    for (width, height) in [(0, 0), (0, 5), (1_000_000, 1), (u32::MAX, u32::MAX)] {
        let error = Plan::new(&scene, &options(&scene, width, height), &limits).expect_err("no such image");
        assert!(matches!(error, PlanError::ImageSize { .. }), "{error}");
    }
    for (width, height) in [(1, 1), (1, 8192), (8192, 1)] {
        assert!(Plan::new(&scene, &options(&scene, width, height), &limits).is_ok());
    }
}

#[test]
fn a_run_can_be_cancelled_and_taken_up_again() {
    let scene = scene("cornell-box.gltf");
    let gpu = gpu();
    block_on(Some(&gpu), async {
        let options = options(&scene, 64, 64);
        let mut renderer = Renderer::new(&scene, &options, &Device::Gpu(gpu.clone())).await.expect("a renderer");
        let stopped = renderer.run(|_| ControlFlow::Break(())).await;
        assert!(matches!(stopped, Err(RenderError::Cancelled { passes }) if passes > 0), "{stopped:?}");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("the rest");
        let resumed = renderer.image().await.expect("an image");
        renderer.restart();
        renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
        assert_eq!(resumed, renderer.image().await.expect("an image"));
    });
}

/// Dropping a future while the GPU works must not leave the renderer unusable or ahead of its records.
#[test]
fn a_dropped_future_leaves_the_renderer_as_it_was() {
    let scene = scene("cornell-box.gltf");
    let gpu = gpu();
    let options = options(&scene, 64, 64);
    let expected = block_on(Some(&gpu), async {
        let mut renderer = Renderer::new(&scene, &options, &Device::Gpu(gpu.clone())).await.expect("a renderer");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
        (
            renderer.passes().iter().map(|p| (p.kernel, p.counts.clone())).collect::<Vec<_>>(),
            renderer.image().await.expect("an image"),
        )
    });
    let mut renderer =
        block_on(Some(&gpu), Renderer::new(&scene, &options, &Device::Gpu(gpu.clone()))).expect("a renderer");
    for _ in 0..3 {
        block_on(Some(&gpu), renderer.step()).expect("a pass");
        let mut context = std::task::Context::from_waker(std::task::Waker::noop());
        let mut run = Box::pin(renderer.run(|_| ControlFlow::Continue(())));
        assert!(run.as_mut().poll(&mut context).is_pending());
        drop(run);
    }
    block_on(Some(&gpu), renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
    let passes: Vec<_> = renderer.passes().iter().map(|p| (p.kernel, p.counts.clone())).collect();
    let image = block_on(Some(&gpu), renderer.image()).expect("an image");
    assert_eq!((passes, image), expected);
}

/// f32 cannot distinguish points of such scenes; a grid with an infinite plane would silently lose every ray.
#[test]
fn a_scene_too_small_for_its_place_is_refused() {
    let mut scene = scene("single-triangle.gltf");
    scene.triangles[0] = [[1e30, 0.0, 0.0], [1e30, 1e-10, 0.0], [1e30, 0.0, 1e-10]];
    let error = Plan::new(&scene, &options(&scene, 8, 8), &Limits::CPU).map(|_| ()).expect_err("too far out");
    assert!(matches!(error, PlanError::Extent), "{error}");
    for scale in [1e-38, 1e-20, 1e20, 1e38] {
        let mut scene = raystep_tests::scene("single-triangle.gltf");
        scene.triangles[0] = scene.triangles[0].map(|p| p.map(|v| (f64::from(v) * scale) as f32));
        scene.cameras.clear();
        assert!(Plan::new(&scene, &options(&scene, 8, 8), &Limits::CPU).is_ok(), "{scale:e}");
    }
}
