//! Draws what egui tessellated on the canvas.

use std::collections::BTreeSet;
use std::sync::Arc;

use egui::mutex::RwLock;
use egui_wgpu::{Renderer, RendererOptions};
use raystep_inspector::ui::retained::Retained;
use raystep_kernels::Gpu;
use web_sys::OffscreenCanvas;
use wgpu::util::TextureBlitter;

use crate::device::Opened;

/// Draws frames.
pub(crate) struct Painter {
    gpu: Arc<Gpu>,
    surface: wgpu::Surface<'static>,
    canvas: OffscreenCanvas,
    configuration: wgpu::SurfaceConfiguration,
    pub(crate) renderer: Arc<RwLock<Renderer>>,
    retained: Retained,
    /// To the canvas, which does not keep a frame to draw on.
    blitter: TextureBlitter,
    /// The canvas does not show the last frame.
    is_stale: bool,
}

/// What egui wants to be drawn.
pub(crate) struct Frame<'a> {
    pub(crate) jobs: Vec<egui::ClippedPrimitive>,
    pub(crate) textures: &'a mut egui::TexturesDelta,
    /// The inspector's pictures with other contents.
    pub(crate) redrawn: BTreeSet<egui::TextureId>,
    pub(crate) size_in_pixels: [u32; 2],
    pub(crate) pixels_per_point: f32,
    pub(crate) background: egui::Color32,
}

impl Painter {
    pub(crate) fn new(canvas: OffscreenCanvas, opened: Opened) -> Result<Self, String> {
        let Opened { gpu, surface, adapter, .. } = opened;
        let mut configuration =
            surface.get_default_config(&adapter, 1, 1).ok_or("the canvas does not fit to the adapter")?;
        let formats = surface.get_capabilities(&adapter).formats;
        configuration.format = egui_wgpu::preferred_framebuffer_format(&formats).map_err(|e| e.to_string())?;
        configuration.view_formats = vec![configuration.format];
        let options = RendererOptions { dithering: false, ..Default::default() };
        let renderer = Arc::new(RwLock::new(Renderer::new(&gpu.device, configuration.format, options)));
        let blitter = TextureBlitter::new(&gpu.device, configuration.format);
        let retained = Retained::default();
        Ok(Self { gpu, surface, canvas, configuration, renderer, retained, blitter, is_stale: true })
    }

    /// Draws a frame, as far as it differs from the last one; where that fails, only uploads its textures.
    pub(crate) fn paint(&mut self, frame: Frame<'_>) -> Result<(), String> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let textures = frame.textures;
        for (id, delta) in textures.set.iter().flat_map(|(id, all)| all.iter().map(move |delta| (id, delta))) {
            self.renderer.write().update_texture(device, queue, *id, delta);
        }
        self.retained.note(textures, &frame.redrawn);
        let most = device.limits().max_texture_dimension_2d;
        let size = frame.size_in_pixels.map(|side| side.clamp(1, most));
        let mut renderer = self.renderer.write();
        let (format, points) = (self.configuration.format, frame.pixels_per_point);
        let drawn = self.retained.draw(&self.gpu, &mut renderer, format, frame.jobs, frame.background, size, points);
        self.is_stale |= drawn.is_some();
        for id in &textures.free {
            renderer.free_texture(id);
        }
        drop(renderer);
        textures.clear();
        if self.is_stale { self.present(size) } else { Ok(()) }
    }

    /// The canvas, in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.configuration.width, self.configuration.height]
    }

    fn present(&mut self, [width, height]: [u32; 2]) -> Result<(), String> {
        let Some(last) = self.retained.texture() else { return Ok(()) };
        let device = &self.gpu.device;
        if (width, height) != (self.configuration.width, self.configuration.height) {
            (self.configuration.width, self.configuration.height) = (width, height);
            self.canvas.set_width(width);
            self.canvas.set_height(height);
            self.surface.configure(device, &self.configuration);
        }
        let shown = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(shown) => shown,
            other => {
                // To be configured again.
                self.configuration.width = 0;
                return Err(format!("{other:?}"));
            }
        };
        let mut encoder = device.create_command_encoder(&Default::default());
        let [from, to] = [last, &shown.texture].map(|texture| texture.create_view(&Default::default()));
        self.blitter.copy(device, &mut encoder, &from, &to);
        self.gpu.submit([encoder.finish()]);
        self.gpu.queue.present(shown);
        self.is_stale = false;
        Ok(())
    }
}
