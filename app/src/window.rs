//! The inspector's window: a device of our own, files and dialogs, and a picture of it where there is no display.

mod files;
mod host;
mod screenshot;
mod thread;

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupExisting};
use raystep_inspector::session::engine::Devices;
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::{Arrival, Inspector};
use raystep_kernels::Gpu;

use crate::device::now_ns;
use crate::error::Error;
pub(crate) use host::SceneChoice;
pub(crate) use screenshot::screenshot;

/// What to show first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Start {
    /// The scene; `None` shows an empty window.
    pub(crate) scene: Option<SceneChoice>,
    /// What to run.
    pub(crate) settings: Settings,
    /// Where to go in it.
    pub(crate) arrival: Arrival,
    /// Points, width and height.
    pub(crate) size: [f32; 2],
}

/// Whether a window can be opened, as far as one can tell without opening one.
pub(crate) fn has_display() -> bool {
    if !cfg!(all(unix, not(target_os = "macos"))) {
        return true;
    }
    ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"]
        .iter()
        .any(|name| std::env::var_os(name).is_some_and(|v| !v.is_empty()))
}

/// Opens the window and stays until it is closed.
pub(crate) fn open(gpu: Arc<Gpu>, start: Start) -> Result<(), Error> {
    let source = gpu.source.clone().ok_or_else(|| Error::failed("the GPU device was opened by somebody else"))?;
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
    let options = eframe::NativeOptions {
        viewport,
        wgpu_options: WgpuConfiguration { wgpu_setup: setup, ..Default::default() },
        ..Default::default()
    };
    let lost = Arc::new(std::sync::Mutex::new(None));
    let found = lost.clone();
    let opened = eframe::run_native(
        "raystep",
        options,
        Box::new(move |creation| {
            let state = creation.wgpu_render_state.as_ref().ok_or("the window has no wgpu device")?;
            let renderer = state.renderer.clone();
            Ok(Box::new(Window::new(&creation.egui_ctx, gpu, renderer, start, found)))
        }),
    );
    opened.map_err(|e| Error::failed(format!("the window cannot be opened: {e}")))?;
    match lost.lock().ok().and_then(|mut lost| lost.take()) {
        Some(message) => Err(Error::failed(message)),
        None => Ok(()),
    }
}

/// An inspector for a context of egui's.
pub(crate) fn inspector(
    ctx: &egui::Context,
    gpu: &Arc<Gpu>,
    renderer: Arc<egui::mutex::RwLock<eframe::egui_wgpu::Renderer>>,
    start: Start,
) -> Inspector {
    let woken = ctx.clone();
    let wake = Arc::new(move || woken.request_repaint());
    let devices = Devices { gpu: gpu.clone(), clock: Some(now_ns), wake };
    let host = host::Desktop::new(ctx.clone(), gpu.clone());
    let mut inspector = Inspector::new(devices, renderer, Box::new(host));
    if let Some(scene) = start.scene {
        inspector.open(&scene.to_string(), start.settings, start.arrival);
    }
    inspector
}

/// Time between two looks at what is to be kept.
const KEEP_EVERY: Duration = Duration::from_secs(10);

struct Window {
    inspector: Inspector,
    gpu: Arc<Gpu>,
    lost: Arc<std::sync::Mutex<Option<String>>>,
    title: String,
    /// When the session was kept last.
    kept: Instant,
}

impl Window {
    fn new(
        ctx: &egui::Context,
        gpu: Arc<Gpu>,
        renderer: Arc<egui::mutex::RwLock<eframe::egui_wgpu::Renderer>>,
        start: Start,
        lost: Arc<std::sync::Mutex<Option<String>>>,
    ) -> Self {
        let mut inspector = inspector(ctx, &gpu, renderer, start);
        if let Some(kept) = files::recall() {
            inspector.restore(&kept);
        }
        Self { inspector, gpu, lost, title: String::new(), kept: Instant::now() }
    }
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        if let Err(error) = self.gpu.health() {
            self.inspector.keep();
            // Nothing can be drawn any more: what is left is to say so, and how to go on.
            let message = format!("{error}{}", self.inspector.how_to_go_on());
            if let Ok(mut lost) = self.lost.lock() {
                lost.get_or_insert(message);
            }
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        self.inspector.ui(ui);
        // Most often nothing is lost where the program is ended from outside.
        if self.kept.elapsed() > KEEP_EVERY {
            self.kept = Instant::now();
            self.inspector.keep();
        }
        ui.ctx().request_repaint_after(KEEP_EVERY);
        let title = self.inspector.title();
        if title != self.title {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    fn on_exit(&mut self) {
        self.inspector.keep();
    }
}
