//! `cargo run --release -p raystep-tests --example grid_sweep -- [gpu|cpu] [SIZE] [REPEATS]`: time to trace at grid
//! resolutions from a quarter to four times the automatic one, in steps of 1.26, for several kinds of scenes, with
//! `second` and no empty-space skipping. The runs of one scene are interleaved; their median is reported.

use std::ops::ControlFlow;

use raystep_kernels::structures::grid::automatic_cells;
use raystep_kernels::{AdapterChoice, Device, Gpu, GridSize, Renderer, ScheduleKind, Skip};
use raystep_lab::Machine;
use raystep_lab::meter::{Meter, Turns, in_turn};
use raystep_lab::statistics::median;
use raystep_scenes::{Scene, generate};
use raystep_tests::{options, scene};

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
    let meter = Meter::new(Machine { device, reason: "as asked for".into() });
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
        sweep(&meter, name, scene, size, repeats as usize);
    }
}

fn sweep(meter: &Meter, name: &str, scene: &Scene, size: u32, repeats: usize) {
    let extent = (scene.bounds().max - scene.bounds().min).as_dvec3().to_array();
    let automatic = automatic_cells(scene.triangles.len() as u64, extent);
    let mut runs: Vec<(f64, GridSize, Renderer)> = Vec::new();
    for step in -6..=6 {
        let factor = 1.26f64.powi(step);
        // Step 0 is the automatic resolution.
        let cells =
            automatic.map(|n| if n == 1 { 1 } else { (f64::from(n) * factor).round().clamp(1.0, 4096.0) as u32 });
        let grid = if step == 0 { GridSize::Auto } else { GridSize::Cells(cells) };
        let mut options = options(scene, size, size);
        (options.grid, options.shade) = (grid, false);
        (options.schedule, options.skip) = (ScheduleKind::Second, Skip::Off);
        let renderer = meter.machine.wait(Renderer::new(scene, &options, &meter.machine.device)).expect("a renderer");
        runs.push((factor, grid, renderer));
    }
    let run = |(_, _, renderer): &mut (f64, GridSize, Renderer)| {
        meter.machine.wait(meter.run(renderer, |_, _| ControlFlow::Continue(())))
    };
    let times = in_turn(&mut runs, Turns::of(1, repeats), run).expect("runs");
    println!("\n{name}: {} triangles", scene.triangles.len());
    let medians: Vec<f64> = times.iter().map(|times| median(&times.wall_ns()).unwrap_or(f64::NAN)).collect();
    let best = medians.iter().copied().fold(f64::INFINITY, f64::min);
    for ((factor, grid, renderer), median_ns) in runs.iter().zip(medians) {
        let cells = renderer.data().grid.cells;
        let references = renderer.data().grid_items.len();
        let mark = if *grid == GridSize::Auto { "  automatic" } else { "" };
        println!(
            "  {factor:>5.2}  {:>4} x {:>4} x {:>4}  {references:>9} references  {:>5} passes  {:>9.2} ms  {:>5.2}{mark}",
            cells[0],
            cells[1],
            cells[2],
            renderer.pass_count(),
            median_ns / 1e6,
            median_ns / best,
        );
    }
}
