//! How long the interface's thread takes for a frame while a scene is played: `Inspector::ui`, textures and
//! tessellation; presenting apart, which waits for the screen.
//!
//! `cargo run --release -p raystep-inspector --example frame_time [FRAMES [TRIANGLES]]`
//!
//! On Linux it prints the thread's own time on the CPU, else wall-clock time, which is the same where nothing else runs:
//! software Vulkan, for one, traces on the same cores.

mod common;

use std::sync::Arc;
use std::time::{Duration, Instant};

use common::Threads;
use egui::mutex::RwLock;
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use raystep_inspector::command::{Command, Layout};
use raystep_inspector::session::devices::Devices;
use raystep_inspector::session::measure::on_its_device;
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::{Arrival, Inspector};
use raystep_kernels::{AdapterChoice, Gpu};
use raystep_lab::statistics::quantile;

/// The frame's budget.
const MOST: Duration = Duration::from_millis(8);
/// Between two frames, as a screen of 60 Hz has it.
const FRAME: Duration = Duration::from_micros(16_667);
const SIZE: [f32; 2] = [1600.0, 900.0];

/// The time that this thread has spent on a CPU so far.
fn now(begin: Instant) -> Duration {
    // The kernel brings the count up to date when the thread is off the CPU.
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let ns = text.and_then(|text| text.split_whitespace().next()?.parse().ok());
    ns.map_or_else(|| begin.elapsed(), Duration::from_nanos)
}

/// A window without a screen.
struct Window {
    ctx: egui::Context,
    gpu: Arc<Gpu>,
    renderer: Arc<RwLock<Renderer>>,
    inspector: Inspector,
    begin: Instant,
}

impl Window {
    /// A frame, and how long `ui` and tessellation took.
    fn frame(&mut self) -> [Duration; 2] {
        let (begin, start) = (Instant::now(), now(self.begin));
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, SIZE.into())),
            time: Some(self.begin.elapsed().as_secs_f64()),
            ..Default::default()
        };
        let mut output = self.ctx.run_ui(input, |ui| self.inspector.ui(ui));
        let ui = now(self.begin);
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let mut renderer = self.renderer.write();
        for (id, delta) in output.textures_delta.set.iter().flat_map(|(id, all)| all.iter().map(move |d| (id, d))) {
            renderer.update_texture(device, queue, *id, delta);
        }
        let jobs = self.ctx.tessellate(output.shapes, 1.0);
        let tessellated = now(self.begin);
        let screen = ScreenDescriptor { size_in_pixels: SIZE.map(|side| side as u32), pixels_per_point: 1.0 };
        let mut encoder = device.create_command_encoder(&Default::default());
        let buffers = renderer.update_buffers(device, queue, &mut encoder, &jobs, &screen);
        self.gpu.submit(buffers.into_iter().chain([encoder.finish()]));
        for id in &output.textures_delta.free {
            renderer.free_texture(id);
        }
        output.textures_delta.clear();
        drop(renderer);
        std::thread::sleep(FRAME.saturating_sub(begin.elapsed()));
        [ui - start, tessellated - ui]
    }

    fn settle(&mut self) {
        let mut calm = 0;
        while calm < 5 {
            self.frame();
            calm = if self.inspector.is_busy() { 0 } else { calm + 1 };
        }
    }
}

fn percentiles(name: &str, times: impl Iterator<Item = Duration>) -> Duration {
    let seconds: Vec<f64> = times.map(|time| time.as_secs_f64()).collect();
    let at = |share: f64| Duration::from_secs_f64(quantile(&seconds, share).unwrap_or(0.0));
    println!("{name:>14}: p50 {:>8.3?}, p90 {:>8.3?}, p99 {:>8.3?}, max {:>8.3?}", at(0.5), at(0.9), at(0.99), at(1.0));
    at(0.99)
}

fn main() -> Result<(), String> {
    let mut args = std::env::args().skip(1);
    let mut number =
        |default: u64| args.next().map_or(Ok(default), |arg| arg.parse().map_err(|e| format!("{arg}: {e}")));
    let (frames, triangles) = (number(300)?.max(1), number(60_000)?);
    let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).map_err(|e| e.to_string())?;
    println!("adapter: {}", gpu.info.name);
    let options = RendererOptions::PREDICTABLE;
    let renderer = Arc::new(RwLock::new(Renderer::new(&gpu.device, wgpu::TextureFormat::Rgba8Unorm, options)));
    let devices = Devices { gpu: gpu.clone(), clock: None, measure: on_its_device(), wake: Arc::new(|| {}) };
    let host = Threads { gpu: gpu.clone(), triangles };
    let mut inspector = Inspector::new(devices, renderer.clone(), Box::new(host));
    inspector.open("terrain", Settings::default(), Arrival::default());
    let mut window = Window { ctx: egui::Context::default(), gpu, renderer, inspector, begin: Instant::now() };
    window.settle();
    let plan = window.inspector.model().opened.as_ref().map(|opened| opened.plan.clone()).ok_or("no run")?;
    println!(
        "{} triangles, {} × {} rays, opened in {:?}",
        plan.triangles,
        plan.width,
        plan.height,
        window.begin.elapsed()
    );
    for (name, layout) in
        [("Overview layout", Command::Arrange(Layout::Overview)), ("Step layout", Command::Arrange(Layout::Step))]
    {
        for command in [layout, Command::Start] {
            window.inspector.perform(command);
            window.settle();
        }
        window.inspector.perform(Command::Play);
        let times: Vec<[Duration; 2]> = (0..frames).map(|_| window.frame()).collect();
        println!("{name}: {frames} frames, {} passes played", window.inspector.model().place);
        percentiles("ui", times.iter().map(|t| t[0]));
        percentiles("tessellation", times.iter().map(|t| t[1]));
        let p99 = percentiles("both", times.iter().map(|t| t[0] + t[1]));
        println!("{:>14}: {} {MOST:?}", "p99", if p99 <= MOST { "within" } else { "over" });
        window.inspector.perform(Command::Cancel);
        window.settle();
    }
    Ok(())
}
