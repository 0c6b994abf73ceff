//! Device time of every accelerator and schedule, on one scene: what the kernels are tuned by.
//!
//! ```text
//! cargo run --release -p raystep-tests --example speed -- gpu|cpu scene.glb 1920x1080 10 [EYE LOOK_AT FOV]
//! ```
//!
//! Points are X,Y,Z and the vertical field of view is in degrees. `raystep bench` measures with more care; this one is quick.

use raystep_kernels::ray_kinds::PrimaryHits;
use raystep_kernels::{Accelerator, Device, Load, Options, RaySource, Renderer, ScheduleKind, Skip};
use raystep_scenes::{Camera, LoadOptions, NoFiles, Projection, Scene};
use raystep_tests::{block_on, camera, gpu};
use std::ops::ControlFlow;
use std::time::Instant;

fn point(text: &str) -> glam::DVec3 {
    let v: Vec<f64> = text.split(',').map(|part| part.parse().expect("a number")).collect();
    glam::dvec3(v[0], v[1], v[2])
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let is_gpu = args[0] == "gpu";
    let bytes = std::fs::read(&args[1]).expect("a scene");
    let scene = raystep_scenes::load(&args[1], &bytes, &NoFiles, &LoadOptions::default()).expect("a scene");
    let (width, height) = args[2].split_once('x').expect("WxH");
    let (width, height): (u32, u32) = (width.parse().expect("width"), height.parse().expect("height"));
    let repeats: usize = args[3].parse().expect("repeats");
    let camera = match &args[4..] {
        [eye, look_at, fov, ..] => {
            let vertical_fov = fov.parse::<f64>().expect("fov").to_radians();
            let projection = Projection::Perspective { vertical_fov };
            Camera::look_at(point(eye), point(look_at), glam::DVec3::Y, projection).expect("a camera")
        }
        _ => camera(&scene),
    };
    let filter = args.get(7).cloned().unwrap_or_default();
    fn now() -> u64 {
        use std::sync::OnceLock;
        static START: OnceLock<Instant> = OnceLock::new();
        START.get_or_init(Instant::now).elapsed().as_nanos() as u64
    }
    let device = if is_gpu { Device::Gpu(gpu()) } else { Device::Cpu(Some(now)) };
    println!("{}: {} triangles, {width}x{height}", args[1], scene.triangles.len());

    let primary = RaySource::Camera { camera: camera.clone(), width, height };
    let hits = {
        let mut options = Options::new(primary.clone());
        (options.accelerator, options.schedule, options.shade) = (Accelerator::Bvh, ScheduleKind::Fused, false);
        let renderer = run(&scene, &options, &device).0;
        block_on(renderer.gpu().map(|g| &**g.gpu()), renderer.hits()).expect("hits")
    };
    let bounce = PrimaryHits { scene: &scene, camera: &camera, width, hits: &hits }.bounce(1);
    for (rays_name, rays) in [("primary", primary), ("bounce", RaySource::Given(bounce))] {
        for (accelerator, schedule, steps, skip) in [
            (Accelerator::Bvh, ScheduleKind::Fused, 1, Skip::Off),
            (Accelerator::Grid, ScheduleKind::Fused, 1, Skip::Off),
            (Accelerator::Grid, ScheduleKind::Fused, 1, Skip::On),
            (Accelerator::None, ScheduleKind::Fused, 1, Skip::Off),
            (Accelerator::Bvh, ScheduleKind::Compact, 1, Skip::Off),
            (Accelerator::Bvh, ScheduleKind::Compact, 8, Skip::Off),
            (Accelerator::Bvh, ScheduleKind::Compact, 32, Skip::Off),
            (Accelerator::Grid, ScheduleKind::Compact, 1, Skip::Off),
            (Accelerator::Grid, ScheduleKind::Compact, 1, Skip::On),
            (Accelerator::Grid, ScheduleKind::Compact, 8, Skip::Off),
            (Accelerator::Grid, ScheduleKind::Compact, 8, Skip::On),
            (Accelerator::Grid, ScheduleKind::Compact, 32, Skip::On),
            (Accelerator::Grid, ScheduleKind::Second, 1, Skip::Off),
            (Accelerator::Bvh, ScheduleKind::Second, 1, Skip::Off),
        ] {
            let label = format!("{rays_name} {accelerator} {schedule} K{steps} skip {skip}");
            if !label.contains(&filter) || (accelerator == Accelerator::None && scene.triangles.len() > 2000) {
                continue;
            }
            let mut options = Options::new(rays.clone());
            (options.accelerator, options.schedule, options.shade) = (accelerator, schedule, false);
            (options.steps_per_pass, options.skip) = (steps, skip);
            options.timings = !is_gpu;
            let begin = Instant::now();
            let (mut renderer, mut times) = run(&scene, &options, &device);
            let build = begin.elapsed().as_secs_f64();
            let begin = Instant::now();
            let load = renderer.gpu().map(|g| Load::new(g.gpu().clone()));
            while times.len() <= repeats && begin.elapsed().as_secs_f64() < 6.0 {
                let is_warm = load.is_none() || begin.elapsed().as_secs_f64() > 0.3;
                renderer.restart();
                load.iter().for_each(Load::submit);
                let time = finish(&mut renderer);
                times.extend(is_warm.then_some(time));
            }
            let mut after: Vec<u64> = times[1..].iter().copied().flatten().collect();
            after.sort_unstable();
            let Some(&median) = after.get(after.len() / 2) else { continue };
            let rays = renderer.plan().rays as f64;
            println!(
                "{label:<42} {:>9.1} us {:>9.1} Mray/s  {:>5} passes  min {:>9.1} us, first run with build {build:.2} s",
                median as f64 / 1e3,
                rays / median as f64 * 1e3,
                renderer.passes().len(),
                after[0] as f64 / 1e3,
            );
        }
    }
}

fn run(scene: &Scene, options: &Options, device: &Device) -> (Renderer, Vec<Option<u64>>) {
    let gpu = match device {
        Device::Gpu(gpu) => Some(&**gpu),
        _ => None,
    };
    let mut renderer = block_on(gpu, Renderer::new(scene, options, device)).expect("a renderer");
    let time = finish(&mut renderer);
    (renderer, vec![time])
}

fn finish(renderer: &mut Renderer) -> Option<u64> {
    let gpu = renderer.gpu().map(|g| g.gpu().clone());
    block_on(gpu.as_deref(), renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
    renderer.device_ns()
}
