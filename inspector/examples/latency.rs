//! How long the window takes to answer: from a click, a key or a movement of the mouse to the end of the frame that shows
//! the result, drawn in full, without a screen.
//!
//! `cargo run --release -p raystep-inspector --example latency -- [gpu|cpu [TRIANGLES]]`
//!
//! Two idle repaints stand beside: no answer is shown sooner than a repaint takes, and one that needs two frames takes
//! two of them.

mod common;

use std::sync::Arc;
use std::time::{Duration, Instant};

use common::Threads;
use egui::mutex::RwLock;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, pos2};
use egui_wgpu::{Renderer, RendererOptions};
use raystep_inspector::draw::picture::{FORMAT, picture};
use raystep_inspector::session::engine::Devices;
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::command::Command;
use raystep_inspector::ui::pane::PaneKind;
use raystep_inspector::ui::{Arrival, Inspector, background, offscreen};
use raystep_kernels::{AdapterChoice, Gpu};
use raystep_lab::block_on;
use raystep_lab::statistics::quantile;

const SIZE: [u32; 2] = [1280, 800];
/// Actions of each kind.
const TIMES: usize = 50;
/// Time limit of an action.
const PATIENCE: Duration = Duration::from_secs(60);

/// A window without a screen.
struct Window {
    ctx: egui::Context,
    gpu: Arc<Gpu>,
    renderer: Arc<RwLock<Renderer>>,
    target: wgpu::Texture,
    inspector: Inspector,
    begin: Instant,
    pointer: Pos2,
    /// What the last frame took: interface, tessellation, drawing.
    parts: [Duration; 3],
}

impl Window {
    /// A frame with these events, drawn to its last pixel.
    fn frame(&mut self, events: Vec<Event>) {
        let (size, start) = (SIZE.map(|side| side as f32), Instant::now());
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(Pos2::ZERO, size.into())),
            time: Some(self.begin.elapsed().as_secs_f64()),
            events,
            ..Default::default()
        };
        let mut output = self.ctx.run_ui(input, |ui| self.inspector.ui(ui));
        let laid_out = start.elapsed();
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let mut renderer = self.renderer.write();
        for (id, delta) in output.textures_delta.set.iter().flat_map(|(id, all)| all.iter().map(move |d| (id, d))) {
            renderer.update_texture(device, queue, *id, delta);
        }
        let jobs = self.ctx.tessellate(output.shapes, 1.0);
        let tessellated = start.elapsed();
        offscreen::submit(&self.gpu, &mut renderer, &jobs, background(&self.ctx), &self.target, 1.0);
        for id in &output.textures_delta.free {
            renderer.free_texture(id);
        }
        output.textures_delta.clear();
        drop(renderer);
        let (done, drawn) = std::sync::mpsc::channel();
        // Nobody listens any more if the wait was given up.
        queue.on_submitted_work_done(move || {
            let _ = done.send(());
        });
        while drawn.try_recv().is_err() && start.elapsed() < PATIENCE {
            // A lost device is reported by the next frame.
            let _ = device.poll(wgpu::PollType::Poll);
            std::thread::sleep(Duration::from_micros(100));
        }
        self.parts = [laid_out, tessellated - laid_out, start.elapsed() - tessellated];
    }

    /// Draws frames until nothing happens any more.
    fn settle(&mut self) {
        let mut calm = 0;
        while calm < 8 {
            self.frame(Vec::new());
            calm = if self.inspector.is_busy() { 0 } else { calm + 1 };
        }
        std::thread::sleep(Duration::from_millis(20));
    }

    /// The time from some events to the end of the second frame in which `holds`: a frame that receives an answer may
    /// show it only in the next.
    fn time(&mut self, events: Vec<Event>, holds: impl Fn(&Self) -> bool) -> Duration {
        let start = Instant::now();
        self.frame(events);
        while !holds(self) && start.elapsed() < PATIENCE {
            self.frame(Vec::new());
        }
        self.frame(Vec::new());
        start.elapsed()
    }

    fn click(&mut self, at: Pos2) -> Vec<Event> {
        self.pointer = at;
        let button = |pressed| Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        vec![Event::PointerMoved(at), button(true), button(false)]
    }

    /// The same until another ray is selected, and its history is there.
    fn time_of_ray(&mut self, events: Vec<Event>) -> Duration {
        let before = self.inspector.pixel();
        self.time(events, |window| {
            let pixel = window.inspector.pixel();
            pixel != before && window.inspector.model().life.as_ref().map(|life| life.pixel) == pixel
        })
    }

    /// Prints a row of times of an action.
    fn times(&mut self, name: &str, limit_ms: f64, count: usize, mut action: impl FnMut(&mut Self, usize) -> Duration) {
        let times: Vec<Duration> = (0..count).map(|i| action(self, i)).collect();
        row(name, limit_ms, &times);
        self.settle();
    }

    fn key(modifiers: Modifiers, key: Key) -> Vec<Event> {
        let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        vec![event(true), event(false)]
    }
}

fn row(name: &str, limit_ms: f64, times: &[Duration]) {
    let ms: Vec<f64> = times.iter().map(|time| 1e3 * time.as_secs_f64()).collect();
    let at = |share: f64| quantile(&ms, share).unwrap_or(f64::NAN);
    let is_within = if at(0.5) <= limit_ms { "within" } else { "over" };
    println!("| {name} | {} | {:.0} | {:.0} | {:.0} | {is_within} {limit_ms} |", ms.len(), at(0.5), at(0.9), at(1.0));
}

fn main() -> Result<(), String> {
    let mut args = std::env::args().skip(1);
    let device = match args.next().as_deref() {
        None | Some("gpu") => DeviceKind::Gpu,
        Some("cpu") => DeviceKind::Cpu,
        Some(other) => return Err(format!("{other}: expected gpu or cpu")),
    };
    let triangles = args.next().map_or(Ok(0), |text| text.parse().map_err(|e| format!("{text}: {e}")))?;
    let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).map_err(|e| e.to_string())?;
    block_on(Some(&gpu), gpu.check_clock(raystep_lab::machine::now_ns)).map_err(|e| e.to_string())?;
    println!("drawn by {}, traced by {}", gpu.info.name, device.name());
    let renderer = Arc::new(RwLock::new(Renderer::new(&gpu.device, FORMAT, RendererOptions::PREDICTABLE)));
    let now = Some(raystep_lab::machine::now_ns as fn() -> u64);
    let devices = Devices { gpu: gpu.clone(), clock: now, measure: None, wake: Arc::new(|| {}) };
    let host = Threads { gpu: gpu.clone(), triangles };
    let inspector = Inspector::new(devices, renderer.clone(), Box::new(host));
    let target = picture(&gpu.device, SIZE);
    let (ctx, begin) = (egui::Context::default(), Instant::now());
    let mut window =
        Window { ctx, gpu, renderer, target, inspector, begin, pointer: Pos2::ZERO, parts: Default::default() };
    window.settle();

    let settings = Settings { device, ..Settings::default() };
    window.inspector.open("scene", settings, Arrival::picture());
    let is_there = |w: &Window| w.inspector.model().is_complete && !w.inspector.is_busy();
    let opened = window.time(Vec::new(), is_there);
    window.settle();
    let end = {
        let model = window.inspector.model();
        let plan = &model.opened.as_ref().ok_or("the scene could not be opened")?.plan;
        println!("{} triangles, {} × {} rays, {} passes\n", plan.triangles, plan.width, plan.height, model.place);
        model.place
    };
    println!("| action | times | median, ms | 90% | worst | limit, ms |\n|---|--:|--:|--:|--:|---|");
    row("open, until the picture is there", 1500.0, &[opened]);
    let mut parts = [const { Vec::new() }; 3];
    let repaints = (0..TIMES).map(|_| {
        let time = window.time(Vec::new(), |_| true);
        parts.iter_mut().zip(window.parts).for_each(|(all, part)| all.push(part));
        time
    });
    let repaints: Vec<Duration> = repaints.collect();
    row("two idle repaints", 50.0, &repaints);
    for (name, times) in ["– layout of one", "– tessellation of one", "– drawing of one"].into_iter().zip(parts) {
        row(name, 25.0, &times);
    }

    let mut random = raystep_lab::rays::Random::new(1);
    // The picture lies in the middle of the simple layout.
    let mut place = || pos2(320.0 + 360.0 * random.unit() as f32, 260.0 + 360.0 * random.unit() as f32);
    window.times("click, until the ray's history is there", 100.0, TIMES, |window, _| {
        let events = window.click(place());
        window.time_of_ray(events)
    });
    window.times("hover", 50.0, TIMES, |window, _| window.time(vec![Event::PointerMoved(place())], |_| true));
    window.times("arrow key, until the neighbour's history is there", 100.0, TIMES, |window, i| {
        window.time_of_ray(Window::key(Modifiers::NONE, if i % 20 < 10 { Key::ArrowLeft } else { Key::ArrowRight }))
    });
    for (name, limit_ms, modifiers, is_there) in [
        ("Shift+F10", 250.0, Modifiers::SHIFT, usize::lt as fn(&usize, &usize) -> bool),
        ("F10", 100.0, Modifiers::NONE, usize::gt),
    ] {
        window.times(name, limit_ms, TIMES.min(end), |window, _| {
            let here = window.inspector.model().place;
            let time = window.time(Window::key(modifiers, Key::F10), |w| is_there(&w.inspector.model().place, &here));
            window.settle();
            time
        });
    }
    window.times("Home, End", 1500.0, 10, |window, i| {
        let (key, wanted) = if i % 2 == 0 { (Key::Home, 0) } else { (Key::End, end) };
        let time = window.time(Window::key(Modifiers::NONE, key), |w| w.inspector.model().place == wanted);
        window.settle();
        time
    });

    window.inspector.perform(Command::FullLayout);
    window.settle();
    if !window.inspector.panes_in_view().contains(&PaneKind::Walk3d) {
        return Err("the full layout has no walk in 3D".into());
    }
    let at = pos2(480.0, 520.0);
    let press =
        |pressed| Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    window.frame(vec![Event::PointerMoved(at), press(true)]);
    window.times("orbit, a frame", 50.0, TIMES, |window, i| {
        let start = Instant::now();
        window.frame(vec![Event::PointerMoved(at + egui::vec2(i as f32, 0.3 * i as f32))]);
        start.elapsed()
    });
    window.frame(vec![press(false)]);
    let at = |i: usize| pos2(660.0 + 560.0 * (0.02 * i as f32).sin(), 720.0);
    let press = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    window.frame(vec![Event::PointerMoved(at(0)), press(at(0), true)]);
    let (start, mut place, mut places) = (Instant::now(), window.inspector.model().place, 0);
    window.times("drag in the timeline, a frame", 50.0, 4 * TIMES, |window, i| {
        let start = Instant::now();
        window.frame(vec![Event::PointerMoved(at(i))]);
        let now = window.inspector.model().place;
        places += usize::from(std::mem::replace(&mut place, now) != now);
        start.elapsed()
    });
    let seconds = start.elapsed().as_secs_f64();
    window.frame(vec![press(at(4 * TIMES), false)]);
    println!("\ndragging showed {places} places in {seconds:.1} s, {:.1} a second", places as f64 / seconds);
    println!("\na limit below two idle repaints is two idle repaints");
    Ok(())
}
