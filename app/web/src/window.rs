//! The window in the page's canvas: events in, frames out.

use std::rc::Rc;
use std::sync::Arc;

use egui::{Event, OutputCommand, Vec2};
use js_sys::Array;
use raystep_inspector::session::devices::Devices;
use raystep_inspector::session::measure::on_its_device;
use raystep_inspector::ui::{Inspector, background};
use raystep_kernels::{Gpu, GpuError};
use wasm_bindgen::prelude::*;
use web_sys::{File, OffscreenCanvas};

use crate::files::Files;
use crate::host::Web;
use crate::input::Input;
use crate::painter::{Frame, Painter};
use crate::{device, shell, tasks};

/// Least time between two changes of the page's address, which browsers limit.
const ADDRESS_EVERY_MS: f64 = 1000.0;
/// Least time between two checks for settings to store.
const KEEP_EVERY_MS: f64 = 10_000.0;

/// The inspector on a canvas.
#[wasm_bindgen]
pub struct Window {
    ctx: egui::Context,
    gpu: Arc<Gpu>,
    painter: Painter,
    inspector: Inspector,
    files: Rc<Files>,
    input: Input,
    title: String,
    /// The last error that assistive technology was told.
    told: String,
    cursor: egui::CursorIcon,
    /// The link in the page's address, and when it was put there.
    address: (String, f64),
    kept_ms: f64,
    is_editing: bool,
}

#[wasm_bindgen]
impl Window {
    /// Opens the best device for a canvas of this size, in CSS pixels, and so many device pixels per CSS pixel. `saved`
    /// is what was kept on the last visit. Rejects with a sentence if nothing can be drawn.
    pub async fn open(
        canvas: OffscreenCanvas,
        width: f32,
        height: f32,
        scale: f32,
        is_dark: bool,
        saved: Option<String>,
    ) -> Result<Self, JsValue> {
        let opened = device::open(&canvas).await?;
        let (gpu, why_not) = (opened.gpu.clone(), opened.why_not.clone());
        tasks::poll(&gpu);
        // On a device without timestamps there is nothing to compare.
        let _ = gpu.check_clock(shell::now_ns).await;
        let painter = Painter::new(canvas, opened)?;
        let ctx = egui::Context::default();
        ctx.set_request_repaint_callback(|asked| shell::wake(asked.delay.as_secs_f64() * 1e3));
        let woken = ctx.clone();
        let wake = Arc::new(move || woken.request_repaint());
        let devices = Devices { gpu: gpu.clone(), clock: Some(shell::now_ns), measure: on_its_device(), wake };
        let files = Rc::new(Files::default());
        let host = Web::new(ctx.clone(), files.clone());
        let mut inspector = Inspector::new(devices, painter.renderer.clone(), Box::new(host));
        if let Some(saved) = saved {
            inspector.restore(saved.as_bytes());
        }
        if let Some(why_not) = why_not {
            inspector.note(format!("kernels run on the CPU, or by WebGL 2 if Options say GPU: {why_not}"));
        }
        let input = Input::new(width, height, scale, is_dark);
        Ok(Self {
            ctx,
            gpu,
            painter,
            inspector,
            files,
            input,
            title: String::new(),
            told: String::new(),
            cursor: egui::CursorIcon::Default,
            address: (String::new(), 0.0),
            kept_ms: shell::now(),
            is_editing: false,
        })
    }

    /// Draws a frame. Returns why there will be no more of them, once the device fails.
    pub fn frame(&mut self) -> Option<String> {
        if let Err(error) = self.gpu.health() {
            self.inspector.keep();
            return Some(match error {
                GpuError::Lost(why) => format!("the GPU device was lost ({why}), with all data on it"),
                other => other.to_string(),
            });
        }
        // WebGL tells of what it has done only when asked.
        drop(self.gpu.device.poll(wgpu::PollType::Poll));
        let most_side = self.gpu.device.limits().max_texture_dimension_2d;
        let raw = self.input.take(shell::now() / 1e3, self.ctx.zoom_factor(), most_side);
        let inspector = &mut self.inspector;
        let mut output = self.ctx.run_ui(raw, |ui| inspector.ui(ui));
        let jobs = self.ctx.tessellate(output.shapes, output.pixels_per_point);
        let frame = Frame {
            jobs,
            textures: &mut output.textures_delta,
            redrawn: self.inspector.take_redrawn(),
            size_in_pixels: self.input.pixels(),
            pixels_per_point: output.pixels_per_point,
            background: background(&self.ctx),
        };
        if self.painter.paint(frame).is_err() {
            self.ctx.request_repaint();
        }
        self.tell_page(output.platform_output);
        self.keep_place();
        None
    }

    /// Whether there is WebGPU; otherwise WebGL 2 draws.
    pub fn computes(&self) -> bool {
        self.gpu.computes
    }

    /// Whether work is in progress.
    pub fn is_busy(&self) -> bool {
        self.inspector.is_busy()
    }

    /// Width and height of the last frame, in pixels.
    pub fn size(&self) -> Vec<u32> {
        self.painter.size().to_vec()
    }

    /// Passes that have run.
    pub fn place(&self) -> usize {
        self.inspector.model().place
    }

    /// The link to what is shown; empty without a scene.
    pub fn link(&self) -> String {
        self.inspector.link().map(|link| link.to_string()).unwrap_or_default()
    }

    /// The last error, in one line; empty if there was none.
    pub fn last_error(&self) -> String {
        self.inspector.last_error().unwrap_or_default().to_owned()
    }

    /// The device that runs kernels; empty without a scene.
    pub fn device(&self) -> String {
        self.inspector.model().opened.as_ref().map(|opened| opened.device.clone()).unwrap_or_default()
    }

    /// Bytes of the module's memory, which never becomes smaller.
    pub fn memory_bytes(&self) -> f64 {
        core::arch::wasm32::memory_size(0) as f64 * 65_536.0
    }

    /// Shows no menus, as a part of another page.
    pub fn embed(&mut self) {
        self.inspector.embed();
        self.ctx.request_repaint();
    }

    /// Begins a lesson by its name, at a step counted from 1.
    pub fn lesson(&mut self, name: &str, step: usize) {
        self.inspector.begin_named_lesson(name, step.saturating_sub(1));
        self.ctx.request_repaint();
    }

    /// Goes to a link, unless it is there already.
    pub fn go(&mut self, link: &str) {
        if link != self.address.0 {
            self.inspector.go_to_link(link);
            self.ctx.request_repaint();
        }
    }

    /// The canvas has another size.
    pub fn resize(&mut self, width: f32, height: f32, scale: f32) {
        self.input.resize(width, height, scale);
        self.ctx.request_repaint();
    }

    /// The pointer is elsewhere.
    pub fn pointer_moved(&mut self, x: f32, y: f32, modifiers: u32) {
        self.input.modified(modifiers);
        self.input.pointer_moved(Input::point(x, y, self.ctx.zoom_factor()));
        self.ctx.request_repaint();
    }

    /// A button was pressed or released.
    pub fn pointer_button(&mut self, x: f32, y: f32, button: u32, pressed: bool, modifiers: u32) {
        self.input.pointer_button(Input::point(x, y, self.ctx.zoom_factor()), button, pressed, modifiers);
        self.ctx.request_repaint();
    }

    /// The pointer left the canvas.
    pub fn pointer_gone(&mut self) {
        self.input.pointer_gone();
        self.ctx.request_repaint();
    }

    /// A finger: its number, and 0 where it begins, 1 where it moves, 2 where it ends, 3 where it is taken away.
    pub fn touch(&mut self, id: u32, phase: u32, x: f32, y: f32, force: f32) {
        self.input.touch(id, phase, Input::point(x, y, self.ctx.zoom_factor()), force);
        self.ctx.request_repaint();
    }

    /// The wheel was turned; `unit` is that of a `WheelEvent`.
    pub fn wheel(&mut self, x: f32, y: f32, unit: u32, modifiers: u32) {
        self.input.wheel(Vec2::new(x, y), unit, modifiers);
        self.ctx.request_repaint();
    }

    /// A key was pressed or released.
    pub fn key(&mut self, name: &str, code: &str, pressed: bool, repeat: bool, modifiers: u32) {
        self.input.key(name, code, pressed, repeat, modifiers);
        self.ctx.request_repaint();
    }

    /// A text was entered, other than by keys.
    pub fn text(&mut self, text: &str) {
        self.input.text(text);
        self.ctx.request_repaint();
    }

    /// A text is being composed, or was (`is_done`).
    pub fn compose(&mut self, text: &str, is_done: bool) {
        if is_done {
            self.input.composed(text)
        } else {
            self.input.composing(text)
        }
        self.ctx.request_repaint();
    }

    /// The user wants the selection on the clipboard.
    pub fn copy(&mut self, cuts: bool) {
        self.input.push(if cuts { Event::Cut } else { Event::Copy });
        self.ctx.request_repaint();
    }

    /// The user wants the clipboard's text here.
    pub fn paste(&mut self, text: String) {
        self.input.push(Event::Paste(text));
        self.ctx.request_repaint();
    }

    /// The page gained or lost the keyboard.
    pub fn focus(&mut self, has_focus: bool) {
        self.input.focus(has_focus);
        self.ctx.request_repaint();
    }

    /// Files were dropped or chosen: their paths, and the files.
    pub fn files(&mut self, paths: Vec<String>, files: Array) {
        let files = files.iter().filter_map(|file| file.dyn_into::<File>().ok());
        self.files.add(paths.into_iter().zip(files).collect());
        self.ctx.request_repaint();
    }

    /// The user chose no file.
    pub fn cancelled(&mut self) {
        self.files.cancel();
        self.ctx.request_repaint();
    }

    /// Stores settings before the page goes away.
    pub fn keep(&mut self) {
        self.inspector.keep();
    }
}

impl Window {
    fn tell_page(&mut self, output: egui::PlatformOutput) {
        for command in output.commands {
            match command {
                OutputCommand::CopyText(text) => shell::copy(&text),
                OutputCommand::OpenUrl(open) => shell::visit(&open.url),
                OutputCommand::CopyImage(_) | OutputCommand::TextSelectionSettled(_) => {}
            }
        }
        if output.cursor_icon != self.cursor {
            self.cursor = output.cursor_icon;
            shell::cursor(css(self.cursor));
        }
        let zoom = self.ctx.zoom_factor();
        match output.ime {
            Some(ime) => {
                let rect = ime.cursor_rect;
                shell::editing(&[rect.left(), rect.top(), rect.width(), rect.height()].map(|n| n * zoom));
            }
            None if self.is_editing => shell::editing(&[]),
            None => {}
        }
        self.is_editing = output.ime.is_some();
        let title = self.inspector.title();
        if title != self.title {
            shell::title(&title);
            self.title = title;
        }
        let error = self.inspector.last_error().unwrap_or_default();
        if error != self.told {
            shell::tell(error);
            error.clone_into(&mut self.told);
        }
    }

    /// Keeps the page's address and the stored settings up to date.
    fn keep_place(&mut self) {
        let now = shell::now();
        let link = self.link();
        if !self.inspector.is_busy() && link != self.address.0 {
            let left_ms = self.address.1 + ADDRESS_EVERY_MS - now;
            if left_ms <= 0.0 {
                shell::address(&link);
                self.address = (link, now);
            } else {
                shell::wake(left_ms);
            }
        }
        if now - self.kept_ms > KEEP_EVERY_MS {
            self.kept_ms = now;
            self.inspector.keep();
        }
        shell::wake(KEEP_EVERY_MS);
    }
}

/// The name of a pointer's shape in CSS.
fn css(icon: egui::CursorIcon) -> &'static str {
    use egui::CursorIcon as C;
    match icon {
        C::Default => "default",
        C::None => "none",
        C::ContextMenu => "context-menu",
        C::Help => "help",
        C::PointingHand => "pointer",
        C::Progress => "progress",
        C::Wait => "wait",
        C::Cell => "cell",
        C::Crosshair => "crosshair",
        C::Text => "text",
        C::VerticalText => "vertical-text",
        C::Alias => "alias",
        C::Copy => "copy",
        C::Move => "move",
        C::NoDrop => "no-drop",
        C::NotAllowed => "not-allowed",
        C::Grab => "grab",
        C::Grabbing => "grabbing",
        C::AllScroll => "all-scroll",
        C::ResizeHorizontal => "ew-resize",
        C::ResizeNeSw => "nesw-resize",
        C::ResizeNwSe => "nwse-resize",
        C::ResizeVertical => "ns-resize",
        C::ResizeEast => "e-resize",
        C::ResizeSouthEast => "se-resize",
        C::ResizeSouth => "s-resize",
        C::ResizeSouthWest => "sw-resize",
        C::ResizeWest => "w-resize",
        C::ResizeNorthWest => "nw-resize",
        C::ResizeNorth => "n-resize",
        C::ResizeNorthEast => "ne-resize",
        C::ResizeColumn => "col-resize",
        C::ResizeRow => "row-resize",
        C::ZoomIn => "zoom-in",
        C::ZoomOut => "zoom-out",
    }
}
