//! A run that takes over another camera, or that shares the structure of another run, traces what a new run would.

use raystep_kernels::{Accelerator, Device, Options, RaySource, Renderer, ScheduleKind, StreamData};
use raystep_scenes::{Camera, Scene};
use raystep_tests::configurations::Configuration;
use raystep_tests::{block_on, devices, gpu_of, options, scene, scene_files, streams_of};

const SIZE: (u32, u32) = (24, 16);

/// The same run from another camera: the scene's own, moved sideways.
fn moved(options: &Options, by: f64, (width, height): (u32, u32)) -> Options {
    let RaySource::Camera { camera, .. } = &options.rays else { panic!("a camera") };
    let camera = Camera { eye: camera.eye + camera.right * by, ..camera.clone() };
    Options { rays: RaySource::Camera { camera, width, height }, ..options.clone() }
}

async fn traced(mut renderer: Renderer) -> (Vec<StreamData>, usize) {
    renderer.run(|_| std::ops::ControlFlow::Continue(())).await.expect("a run");
    let mut all = Vec::new();
    for stream in streams_of(renderer.plan()) {
        all.push(renderer.values(stream).await.expect("values"));
    }
    (all, renderer.pass_count())
}

fn same(label: &str, (a, passes): &(Vec<StreamData>, usize), (b, other): &(Vec<StreamData>, usize)) {
    assert_eq!(passes, other, "{label}");
    assert_eq!(a.len(), b.len(), "{label}");
    for (a, b) in a.iter().zip(b) {
        assert!(a.bits == b.bits, "{label}: {} differs", a.stream.name());
    }
}

fn check(label: &str, scene: &Scene, first: &Options, device: &Device) {
    block_on(gpu_of(device), async {
        let bounds = scene.bounds();
        let size = if bounds.is_empty() { 1.0 } else { bounds.max.as_dvec3().distance(bounds.min.as_dvec3()) };
        let second = moved(first, 0.01 * size, SIZE);
        let fresh = traced(Renderer::new(scene, &second, device).await.expect("a renderer")).await;
        let mut renderer = Renderer::new(scene, first, device).await.expect("a renderer");
        renderer.step().await.expect("a pass");
        assert!(renderer.look(scene, &second).expect("a camera"), "{label}: a small movement needs no new run");
        assert_eq!(renderer.pass_count(), 0, "{label}");
        // A run beside it, smaller and from the first place.
        let smaller = moved(first, 0.0, (11, 7));
        let beside = renderer.viewed(scene, &smaller, device).await.expect("a run").expect("the same structure");
        let beside = traced(beside).await;
        same(label, &traced(renderer).await, &fresh);
        let fresh = Renderer::new(scene, &smaller, device).await.expect("a renderer");
        same(&format!("{label}, smaller"), &beside, &traced(fresh).await);
    });
}

#[test]
fn a_run_takes_over_a_camera_or_shares_its_structure_bit_for_bit() {
    let configurations = [
        Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 1),
        Configuration::new(Accelerator::Bvh, ScheduleKind::Compact, 8),
        Configuration::new(Accelerator::Grid, ScheduleKind::Fused, 1),
        Configuration::new(Accelerator::None, ScheduleKind::Second, 1),
    ];
    for (name, device) in devices() {
        for (file, configuration) in scene_files().into_iter().zip(configurations.into_iter().cycle()) {
            let scene = scene(&file);
            // Brute force over a large scene takes long.
            let configuration = if scene.triangles.len() > 1000 { configurations[0] } else { configuration };
            let first = configuration.of(&options(&scene, SIZE.0, SIZE.1));
            check(&format!("{file}, {configuration} on {name}"), &scene, &first, &device);
        }
    }
}

#[test]
fn a_camera_that_needs_more_is_refused() {
    let device = Device::Cpu(None);
    let scene = scene("cornell-box.gltf");
    let first = Configuration::new(Accelerator::Grid, ScheduleKind::Compact, 1).of(&options(&scene, SIZE.0, SIZE.1));
    block_on(None, async {
        let mut renderer = Renderer::new(&scene, &first, &device).await.expect("a renderer");
        // Far away, rounding errors are larger, and so must be the cells.
        for (other, why) in [
            (moved(&first, 1000.0, SIZE), "far away"),
            (moved(&first, 0.0, (25, 16)), "another size"),
            (orthographic(&first), "parallel rays"),
        ] {
            assert!(!renderer.look(&scene, &other).expect("a camera"), "{why}");
        }
        assert!(renderer.look(&scene, &moved(&first, f64::NAN, SIZE)).is_err());
    });
}

fn orthographic(options: &Options) -> Options {
    let RaySource::Camera { camera, width, height } = &options.rays else { panic!("a camera") };
    let projection = raystep_scenes::Projection::Orthographic { half_height: 1.0 };
    let rays = RaySource::Camera { camera: Camera { projection, ..camera.clone() }, width: *width, height: *height };
    Options { rays, ..options.clone() }
}
