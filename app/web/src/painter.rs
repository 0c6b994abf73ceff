//! Draws what egui tessellated on the canvas.

use std::sync::Arc;

use egui::mutex::RwLock;
use egui_wgpu::{Renderer, RendererOptions};
use raystep_inspector::ui::offscreen;
use raystep_kernels::Gpu;
use web_sys::OffscreenCanvas;

use crate::device::Opened;

/// Draws frames.
pub(crate) struct Painter {
    gpu: Arc<Gpu>,
    surface: wgpu::Surface<'static>,
    canvas: OffscreenCanvas,
    configuration: wgpu::SurfaceConfiguration,
    pub(crate) renderer: Arc<RwLock<Renderer>>,
    is_stale: bool,
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
        Ok(Self { gpu, surface, canvas, configuration, renderer, is_stale: true })
    }

    /// Draws a frame; where that fails, only uploads its textures.
    pub(crate) fn paint(
        &mut self,
        jobs: &[egui::ClippedPrimitive],
        textures: &mut egui::TexturesDelta,
        size_in_pixels: [u32; 2],
        pixels_per_point: f32,
        background: egui::Color32,
    ) -> Result<(), String> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        for (id, delta) in textures.set.iter().flat_map(|(id, all)| all.iter().map(move |delta| (id, delta))) {
            self.renderer.write().update_texture(device, queue, *id, delta);
        }
        let drawn = self.draw(jobs, size_in_pixels, pixels_per_point, background);
        for id in &textures.free {
            self.renderer.write().free_texture(id);
        }
        textures.clear();
        drawn
    }

    fn draw(
        &mut self,
        jobs: &[egui::ClippedPrimitive],
        [width, height]: [u32; 2],
        pixels_per_point: f32,
        background: egui::Color32,
    ) -> Result<(), String> {
        let device = &self.gpu.device;
        let most = device.limits().max_texture_dimension_2d;
        let (width, height) = (width.clamp(1, most), height.clamp(1, most));
        if self.is_stale || (width, height) != (self.configuration.width, self.configuration.height) {
            (self.configuration.width, self.configuration.height) = (width, height);
            self.canvas.set_width(width);
            self.canvas.set_height(height);
            self.surface.configure(device, &self.configuration);
            self.is_stale = false;
        }
        let frame = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(frame) => frame,
            wgpu::CurrentSurfaceTexture::Suboptimal(frame) => {
                self.is_stale = true;
                frame
            }
            other => {
                self.is_stale = true;
                return Err(format!("{other:?}"));
            }
        };
        let mut renderer = self.renderer.write();
        offscreen::submit(&self.gpu, &mut renderer, jobs, background, &frame.texture, pixels_per_point);
        self.gpu.queue.present(frame);
        Ok(())
    }
}
