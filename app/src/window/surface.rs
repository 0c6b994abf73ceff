//! The window's surface, on a queue that is shared with other threads.
//!
//! eframe configures the surface itself: when it opens, on resize events, and before painting if the last acquired
//! texture did not fit. wgpu refuses to do so while another thread submits work. So nothing is submitted while a
//! window's events are handled or while a surface is painted that may have to be configured; a frame that fails all the
//! same is painted again with a newly configured surface.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use eframe::egui;
use eframe::egui_wgpu::{SurfaceConfig, SurfaceErrorAction, WgpuConfiguration};
use eframe::{EframeWinitApplication, UserEvent};
use raystep_kernels::{Gpu, Held};
use raystep_lab::block_on;
use winit::application::ApplicationHandler;
use winit::event::{DeviceEvent, StartCause, WindowEvent};
use winit::event_loop::ActiveEventLoop;
use winit::window::WindowId;

/// Most consecutive failures of frames.
const MOST_FAILURES: usize = 8;

/// The state of the surface, shared by all that use it.
pub(super) struct Surface {
    gpu: Arc<Gpu>,
    ctx: OnceLock<egui::Context>,
    held: Mutex<Option<Held>>,
    /// It must be configured before the next frame.
    is_stale: AtomicBool,
    /// It may be configured before the next frame.
    is_changing: AtomicBool,
    /// Whether a frame was drawn since the current events began.
    is_drawn: AtomicBool,
    /// Failures since the last successful frame.
    failures: AtomicUsize,
    trouble: Mutex<Option<String>>,
}

impl Surface {
    pub(super) fn new(gpu: Arc<Gpu>) -> Arc<Self> {
        Arc::new(Self {
            gpu,
            ctx: OnceLock::new(),
            held: Mutex::default(),
            is_stale: false.into(),
            // The first acquired texture may not fit the size that the window manager chose.
            is_changing: true.into(),
            is_drawn: false.into(),
            failures: 0.into(),
            trouble: Mutex::default(),
        })
    }

    /// Allows requests for frames.
    pub(super) fn opened(&self, ctx: &egui::Context) {
        let _ = self.ctx.set(ctx.clone());
    }

    /// The permanent error, if any.
    pub(super) fn trouble(&self) -> Option<String> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn hold_back(&self) {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        held.get_or_insert_with(|| self.gpu.hold_back());
    }

    fn let_go(&self) {
        self.held.lock().unwrap_or_else(PoisonError::into_inner).take();
    }

    /// Begins a frame: the application submits work of its own.
    pub(super) fn begin_frame(&self) {
        self.let_go();
        self.is_drawn.store(true, Ordering::Relaxed);
    }

    /// About to paint a frame.
    pub(super) fn end_frame(&self, frame: &mut eframe::Frame) {
        let is_stale = self.is_stale.swap(false, Ordering::Relaxed);
        if is_stale && let Some(now) = frame.wgpu_surface_config() {
            // Only changed values are configured. An unset latency is wgpu's default of two frames, so that both agree.
            let other = if now.desired_maximum_frame_latency.is_some() { None } else { Some(2) };
            frame.set_wgpu_surface_config(SurfaceConfig { desired_maximum_frame_latency: other, ..now });
        }
        if self.is_changing.swap(false, Ordering::Relaxed) || is_stale {
            self.hold_back();
        }
    }

    /// eframe's configuration, which notifies before it configures.
    pub(super) fn configuration(self: &Arc<Self>, wgpu_setup: eframe::egui_wgpu::WgpuSetup) -> WgpuConfiguration {
        let usual = WgpuConfiguration { wgpu_setup, ..Default::default() };
        let (surface, decide) = (self.clone(), usual.on_surface_status.clone());
        let on_surface_status = Arc::new(move |status: &wgpu::CurrentSurfaceTexture| {
            let action = decide(status);
            match action {
                SurfaceErrorAction::Reconfigure => surface.hold_back(),
                SurfaceErrorAction::RecreateSurface => surface.is_changing.store(true, Ordering::Relaxed),
                SurfaceErrorAction::SkipFrame => {}
            }
            action
        });
        WgpuConfiguration { on_surface_status, ..usual }
    }

    /// Lets eframe handle an event. Work that the device refuses meanwhile is repeated.
    fn during(&self, work: impl FnOnce()) {
        self.bearing(MOST_FAILURES, work);
    }

    /// The same, with a limit on failures.
    fn bearing(&self, most: usize, work: impl FnOnce()) {
        self.is_drawn.store(false, Ordering::Relaxed);
        let scope = self.gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        work();
        self.let_go();
        match block_on(None, scope.pop()) {
            None if self.is_drawn.load(Ordering::Relaxed) => self.failures.store(0, Ordering::Relaxed),
            None => {}
            Some(error) => {
                if self.failures.fetch_add(1, Ordering::Relaxed) >= most {
                    let message = raystep_kernels::GpuError::from(error).to_string();
                    self.trouble.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
                }
                self.is_stale.store(true, Ordering::Relaxed);
                if let Some(ctx) = self.ctx.get() {
                    ctx.request_repaint();
                }
            }
        }
    }
}

/// eframe's application with a supervised surface.
pub(super) struct Application<'a> {
    pub(super) eframe: EframeWinitApplication<'a>,
    pub(super) surface: Arc<Surface>,
}

impl ApplicationHandler<UserEvent> for Application<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        self.surface.bearing(0, || self.eframe.resumed(event_loop));
        // A surface that was never configured cannot be painted.
        if self.surface.trouble().is_some() {
            event_loop.exit();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, window: WindowId, event: WindowEvent) {
        self.surface.during(|| {
            if !matches!(event, WindowEvent::RedrawRequested) {
                self.surface.hold_back();
            }
            if matches!(event, WindowEvent::Resized(_)) {
                self.surface.is_changing.store(true, Ordering::Relaxed);
            }
            self.eframe.window_event(event_loop, window, event);
        });
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, cause: StartCause) {
        self.surface.during(|| self.eframe.new_events(event_loop, cause));
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: UserEvent) {
        self.surface.during(|| self.eframe.user_event(event_loop, event));
    }

    fn device_event(&mut self, event_loop: &ActiveEventLoop, device: winit::event::DeviceId, event: DeviceEvent) {
        self.surface.during(|| self.eframe.device_event(event_loop, device, event));
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.surface.during(|| self.eframe.about_to_wait(event_loop));
    }

    fn suspended(&mut self, event_loop: &ActiveEventLoop) {
        self.surface.during(|| self.eframe.suspended(event_loop));
    }

    fn exiting(&mut self, event_loop: &ActiveEventLoop) {
        self.surface.during(|| self.eframe.exiting(event_loop));
    }

    fn memory_warning(&mut self, event_loop: &ActiveEventLoop) {
        self.surface.during(|| self.eframe.memory_warning(event_loop));
    }
}
