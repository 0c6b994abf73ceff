//! The inspector's window: its device, files and dialogs, and screenshots without a display.

mod driven;
mod files;
mod host;
mod last_error;
mod measure;
mod opening;
mod screenshot;
mod surface;
mod watch;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use driven::Driven;
use eframe::egui;
use eframe::egui_wgpu::{WgpuSetup, WgpuSetupExisting};
use raystep_inspector::lesson::Lesson;
use raystep_inspector::session::devices::Devices;
use raystep_inspector::session_file::SessionFile;
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::{Arrival, Inspector};
use raystep_kernels::Gpu;
use raystep_lab::machine::now_ns;
use surface::{Application, Surface};
use winit::event_loop::EventLoop;

use crate::args::ReadArgs;
use crate::error::Error;
pub(crate) use host::SceneChoice;
pub(crate) use opening::Opening;
pub(crate) use screenshot::{check_lesson, latency, screenshot};

/// The initial contents.
#[derive(Default)]
pub(crate) struct Start {
    /// The scene; `None` shows an empty window.
    pub(crate) scene: Option<SceneChoice>,
    /// That scene, if it is being read already.
    pub(crate) opening: Option<Opening>,
    /// A session with that scene, and its file; it has settings and place of its own.
    pub(crate) session: Option<(PathBuf, SessionFile)>,
    /// Limits for reading it and each scene opened later.
    pub(crate) read: ReadArgs,
    /// The settings of the run.
    pub(crate) settings: Settings,
    /// The initial place.
    pub(crate) arrival: Arrival,
    /// A lesson, and its step, counted from 0.
    pub(crate) lesson: Option<(Lesson, usize)>,
    /// Points, width and height.
    pub(crate) size: [f32; 2],
    /// When the program began, in nanoseconds, if the window's response times are measured: it drives itself then, does
    /// not restore an earlier state and saves none.
    pub(crate) measured_from: Option<u64>,
}

impl Start {
    /// Begins to read the scene, if it is not that of a session, which has settings of its own.
    pub(crate) fn begin_reading(&mut self) {
        if let (Some(scene), None) = (&self.scene, &self.session) {
            self.opening = Some(Opening::begin(scene.clone(), self.read, self.settings.clone()));
        }
    }
}

/// Whether a window can probably be opened.
pub(crate) fn has_display() -> bool {
    if !cfg!(all(unix, not(target_os = "macos"))) {
        return true;
    }
    ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"]
        .iter()
        .any(|name| std::env::var_os(name).is_some_and(|v| !v.is_empty()))
}

/// Opens the window, and returns when it is closed.
pub(crate) fn open(gpu: Arc<Gpu>, start: Start) -> Result<(), Error> {
    let source = gpu.source.clone().ok_or_else(|| Error::failed("the GPU device has another owner"))?;
    let setup = WgpuSetup::Existing(WgpuSetupExisting {
        instance: source.instance,
        adapter: source.adapter,
        device: gpu.device.clone(),
        queue: gpu.queue.clone(),
    });
    let viewport = egui::ViewportBuilder::default()
        .with_title("raystep")
        .with_app_id("raystep")
        .with_inner_size(start.size)
        .with_min_inner_size([200.0, 150.0])
        .with_drag_and_drop(true);
    let surface = Surface::new(gpu.clone());
    // No panel has a gradient that banding could spoil, and a software adapter draws a frame sooner without dithering.
    let wgpu_options = surface.configuration(setup);
    let options = eframe::NativeOptions { viewport, wgpu_options, dithering: false, ..Default::default() };
    let failed = |reason: String| Error::failed(format!("cannot open the window: {reason}"));
    last_error::listen();
    let event_loop = EventLoop::with_user_event().build().map_err(|e| failed(e.to_string()))?;
    let ended = Arc::new(Ended::default());
    let (ending, shown) = (ended.clone(), surface.clone());
    let eframe = eframe::create_native(
        "raystep",
        options,
        Box::new(move |creation| {
            let state = creation.wgpu_render_state.as_ref().ok_or("the window has no wgpu device")?;
            shown.opened(&creation.egui_ctx);
            ending.is_open.store(true, Ordering::Relaxed);
            let driven = start.measured_from.map(Driven::new);
            let inspector = inspector(&creation.egui_ctx, &gpu, state.renderer.clone(), start);
            Ok(Box::new(Window::new(inspector, gpu, shown, ending, driven)))
        }),
        &event_loop,
    );
    let run = event_loop.run_app(&mut Application { eframe, surface: surface.clone() });
    run.map_err(|e| Error::failed(format!("the window was closed: {e}")))?;
    if !ended.is_open.load(Ordering::Relaxed) {
        let logged =
            || Some(last_error::take_of("eframe")?.trim_start_matches("Exiting because of error: ").to_owned());
        return Err(failed(surface.trouble().or_else(logged).unwrap_or_else(|| "the system gives no reason".into())));
    }
    match ended.lost.lock().ok().and_then(|mut lost| lost.take()).or_else(|| surface.trouble()) {
        Some(message) => Err(Error::failed(message)),
        None => Ok(()),
    }
}

/// An inspector for an egui context.
pub(crate) fn inspector(
    ctx: &egui::Context,
    gpu: &Arc<Gpu>,
    renderer: Arc<egui::mutex::RwLock<eframe::egui_wgpu::Renderer>>,
    start: Start,
) -> Inspector {
    let woken = ctx.clone();
    let wake = Arc::new(move || woken.request_repaint());
    let measure = measure::measure(gpu.info.name.clone());
    let devices = Devices { gpu: gpu.clone(), clock: Some(now_ns), measure, wake };
    let host = host::Desktop::new(ctx.clone(), gpu.clone(), start.read, start.opening);
    let mut inspector = Inspector::new(devices, renderer, Box::new(host));
    if let Some((path, session)) = start.session {
        inspector.open_session(&path.to_string_lossy(), session);
    } else if let Some(scene) = start.scene {
        inspector.open(&scene.to_string(), start.settings, start.arrival);
    }
    if let Some((lesson, step)) = start.lesson {
        inspector.begin_lesson(lesson, step);
    }
    inspector
}

/// Interval between checks for state to save.
const KEEP_EVERY: Duration = Duration::from_secs(10);

/// How a window ended.
#[derive(Default)]
struct Ended {
    /// It was opened.
    is_open: AtomicBool,
    /// Why drawing became impossible.
    lost: Mutex<Option<String>>,
}

struct Window {
    inspector: Inspector,
    gpu: Arc<Gpu>,
    surface: Arc<Surface>,
    ended: Arc<Ended>,
    title: String,
    /// When the session was last saved.
    kept: Instant,
    driven: Option<Driven>,
}

impl Window {
    fn new(
        mut inspector: Inspector,
        gpu: Arc<Gpu>,
        surface: Arc<Surface>,
        ended: Arc<Ended>,
        driven: Option<Driven>,
    ) -> Self {
        if let Some(kept) = files::recall().filter(|_| driven.is_none()) {
            inspector.restore(&kept);
        }
        Self { inspector, gpu, surface, ended, title: String::new(), kept: Instant::now(), driven }
    }

    fn keep(&mut self) {
        if self.driven.is_none() {
            self.inspector.keep();
        }
    }
}

impl eframe::App for Window {
    fn raw_input_hook(&mut self, ctx: &egui::Context, input: &mut egui::RawInput) {
        if let Some(driven) = &mut self.driven {
            driven.frame(ctx, input, &mut self.inspector, &self.gpu);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.surface.begin_frame();
        if let Some(error) = self.gpu.health().err().map(|e| e.to_string()).or_else(|| self.surface.trouble()) {
            self.keep();
            // Drawing is no longer possible: report it, and how to resume.
            let message = format!("{error}{}", self.inspector.how_to_go_on());
            if let Ok(mut lost) = self.ended.lost.lock() {
                lost.get_or_insert(message);
            }
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        self.inspector.ui(ui);
        if let Some(driven) = &mut self.driven {
            driven.after(ui.ctx(), &self.inspector);
        }
        // If a signal ends the program, little or nothing is lost.
        if self.kept.elapsed() > KEEP_EVERY {
            self.kept = Instant::now();
            self.keep();
        }
        ui.ctx().request_repaint_after(KEEP_EVERY);
        let title = self.inspector.title();
        if title != self.title {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        self.surface.end_frame(frame);
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }

    fn on_exit(&mut self) {
        self.keep();
        // Where the system ends the process from within its event loop, nothing comes after this.
        #[cfg(target_os = "macos")]
        let _ = crate::threads::end();
    }
}
