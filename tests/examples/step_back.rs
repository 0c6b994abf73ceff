//! Time to go back one pass in the inspector: at 1920×1080, after 500 passes, from several places.
//!
//! `cargo run --release -p raystep-tests --example step_back -- [gpu|cpu] [WxH] [PASSES]`

use std::time::Instant;

use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::{Session, Target, go_on};
use raystep_kernels::plan::Bytes;
use raystep_kernels::{AdapterChoice, Choices, Device, Gpu, ScheduleKind, Skip};
use raystep_tests::block_on;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |i: usize, default: &str| arguments.get(i).cloned().unwrap_or_else(|| default.into());
    let size = argument(1, "1920x1080");
    let (width, height) = size.split_once('x').expect("WxH");
    let size = [width, height].map(|side| side.parse().expect("a number of pixels"));
    let passes: usize = argument(2, "500").parse().expect("a number of passes");
    let device = match argument(0, "gpu").as_str() {
        "cpu" => Device::Cpu(None),
        _ => Device::Gpu(block_on(None, Gpu::new(&AdapterChoice::Best)).expect("an adapter")),
    };
    let gpu = match &device {
        Device::Gpu(gpu) => Some(gpu.clone()),
        _ => None,
    };
    println!("on {}", gpu.as_ref().map_or("the twins", |gpu| &gpu.info.name));
    let scene = raystep_tests::scene("sphere-flake.glb");
    for schedule in [ScheduleKind::Compact, ScheduleKind::Second] {
        // Without empty-space skipping there are more passes.
        let settings = Settings {
            size,
            device: DeviceKind::Gpu,
            choices: Choices { schedule, skip: Skip::Off, ..Choices::stepped() },
            ..Settings::default()
        };
        block_on(gpu.as_deref(), async {
            let options = settings.options(&scene);
            let mut session = Session::new(&scene, &options, &device).await.expect("a session");
            let start = Instant::now();
            let place = session.step(Target::Pass(passes), &mut go_on).await.expect("passes");
            let there = start.elapsed();
            let mut times = Vec::new();
            while times.len() < 20 && session.place() > 0 {
                let start = Instant::now();
                session.step(Target::Previous, &mut go_on).await.expect("a pass");
                times.push(start.elapsed());
            }
            let start = Instant::now();
            session.follow([size[0] / 2, size[1] / 2], &mut go_on).await.expect("a ray");
            let follow = start.elapsed();
            times.sort_unstable();
            println!(
                "{schedule}: {place} passes in {there:.1?}; one pass back: median {:.1?}, at most {:.1?}; {} kept; a ray followed in {follow:.1?}",
                times[times.len() / 2],
                times[times.len() - 1],
                Bytes(session.kept_bytes()),
            );
        });
    }
}
