//! `cargo run --release -p raystep-tests --example grid_sweep -- [gpu|cpu] [SIZE] [REPEATS]`: time to trace
//! over grid resolution, from a quarter to four times the automatic one in steps of 1.26, for scenes of
//! different kinds, by `second` without leaps. The runs of one scene are interleaved; the median counts.

use std::ops::ControlFlow;
use std::time::Instant;

use raystep_kernels::grid::automatic_cells;
use raystep_kernels::{AdapterChoice, Device, Gpu, GridSize, Renderer, ScheduleKind, Skip};
use raystep_scenes::{Scene, generate};
use raystep_tests::{block_on, options, scene};

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: u32| args.get(i).map_or(default, |v: &String| v.parse().expect("a number"));
    let device = match args.first().map(String::as_str) {
        Some("cpu") => Device::Cpu(None),
        _ => Device::Gpu(pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter")),
    };
    let adapter = match &device {
        Device::Gpu(gpu) => gpu.info.name.clone(),
        _ => "twins".into(),
    };
    let (size, repeats) = (number(1, 512), number(2, 5));
    println!("{adapter}, {size}x{size}, {repeats} repeats, primary rays");
    let scenes: Vec<(&str, Scene)> = vec![
        ("cornell-box", scene("cornell-box.gltf")),
        ("sphere-flake", scene("sphere-flake.glb")),
        ("terrain", scene("terrain.glb")),
        ("teapot", scene("teapot.glb")),
        ("soup of 100,000", generate::soup(100_000, 1).expect("soup")),
        ("hair, 2,000 strands", generate::hair(2_000, 1).expect("hair")),
    ];
    for (name, scene) in &scenes {
        sweep(&device, name, scene, size, repeats);
    }
}

fn sweep(device: &Device, name: &str, scene: &Scene, size: u32, repeats: u32) {
    let extent = (scene.bounds().max - scene.bounds().min).as_dvec3().to_array();
    let automatic = automatic_cells(scene.triangles.len() as u64, extent);
    let mut runs: Vec<(f64, GridSize, Renderer, Vec<f64>)> = Vec::new();
    let gpu = match device {
        Device::Gpu(gpu) => Some(&**gpu),
        _ => None,
    };
    for step in -6..=6 {
        let factor = 1.26f64.powi(step);
        // Step 0 is what a user gets without asking.
        let cells =
            automatic.map(|n| if n == 1 { 1 } else { (f64::from(n) * factor).round().clamp(1.0, 4096.0) as u32 });
        let grid = if step == 0 { GridSize::Auto } else { GridSize::Cells(cells) };
        let mut options = options(scene, size, size);
        (options.grid, options.shade) = (grid, false);
        (options.schedule, options.skip) = (ScheduleKind::Second, Skip::Off);
        let renderer = block_on(gpu, Renderer::new(scene, &options, device)).expect("a renderer");
        runs.push((factor, grid, renderer, Vec::new()));
    }
    for _ in 0..=repeats {
        for (_, _, renderer, times) in &mut runs {
            renderer.restart();
            // Uploads of the restart are not part of the trace.
            if let Some(gpu) = gpu {
                gpu.submit([]);
                drop(gpu.device.poll(wgpu::PollType::wait_indefinitely()));
            }
            let start = Instant::now();
            block_on(gpu, renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
            times.push(start.elapsed().as_secs_f64());
        }
    }
    println!("\n{name}: {} triangles", scene.triangles.len());
    let median = |times: &[f64]| {
        let mut warm = times[1..].to_vec();
        warm.sort_by(f64::total_cmp);
        warm[warm.len() / 2]
    };
    let best = runs.iter().map(|r| median(&r.3)).fold(f64::INFINITY, f64::min);
    for (factor, grid, renderer, times) in &runs {
        let cells = renderer.data().grid.cells;
        let references = renderer.data().grid_items.len();
        let mark = if *grid == GridSize::Auto { "  automatic" } else { "" };
        println!(
            "  {factor:>5.2}  {:>4} x {:>4} x {:>4}  {references:>9} references  {:>5} passes  {:>9.2} ms  {:>5.2}{mark}",
            cells[0],
            cells[1],
            cells[2],
            renderer.pass_count(),
            1e3 * median(times),
            median(times) / best,
        );
    }
}
