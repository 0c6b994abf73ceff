//! The inspector as a picture, drawn by egui's own renderer without a display.

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, mutex::RwLock};
use eframe::egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use raystep_inspector::ui::Inspector;
use raystep_inspector::ui::command::Command;
use raystep_kernels::Gpu;

use super::{Start, inspector};
use crate::error::Error;

/// What egui samples and blends best.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// How long work may go on before the picture is taken of what there is.
const PATIENCE: Duration = Duration::from_secs(300);

/// Draws the interface once nothing is left to do. `commands` are done one after the other before.
pub(crate) fn screenshot(
    gpu: &Arc<Gpu>,
    start: Start,
    scale: f32,
    commands: &[Command],
) -> Result<image::RgbaImage, Error> {
    let [width, height] = start.size.map(|side| (side * scale).round().max(1.0) as u32);
    let most = gpu.device.limits().max_texture_dimension_2d;
    if width > most || height > most {
        return Err(Error::failed(format!("--window: the adapter draws pictures of at most {most} pixels a side")));
    }
    let ctx = egui::Context::default();
    ctx.set_pixels_per_point(scale);
    let renderer = Arc::new(RwLock::new(Renderer::new(&gpu.device, FORMAT, RendererOptions::PREDICTABLE)));
    let (points, is_asked) = (start.size, start.scene.is_some());
    let inspector = inspector(&ctx, gpu, renderer.clone(), start);
    let mut stage = Stage { ctx, gpu: gpu.clone(), renderer, inspector, points, time: 0.0, scale };
    stage.settle()?;
    if is_asked && stage.inspector.model().opened.is_none() {
        return Err(Error::failed(stage.inspector.last_error().unwrap_or("the scene could not be opened")));
    }
    for &command in commands {
        stage.inspector.perform(command);
        stage.settle()?;
    }
    let jobs = stage.frame();
    stage.draw(&jobs, [width, height])
}

struct Stage {
    ctx: egui::Context,
    gpu: Arc<Gpu>,
    renderer: Arc<RwLock<Renderer>>,
    inspector: Inspector,
    points: [f32; 2],
    time: f64,
    scale: f32,
}

impl Stage {
    /// Frames until nothing goes on, and a few more for what needs several to find its size.
    fn settle(&mut self) -> Result<(), Error> {
        let begin = Instant::now();
        let mut calm = 0;
        while calm < 6 {
            self.gpu.health()?;
            self.frame();
            calm = if self.inspector.is_busy() { 0 } else { calm + 1 };
            if calm == 0 {
                if begin.elapsed() > PATIENCE {
                    return Err(Error::failed(format!("the scene was not ready after {PATIENCE:?}")));
                }
                std::thread::sleep(Duration::from_millis(5));
            }
        }
        Ok(())
    }

    fn frame(&mut self) -> Vec<egui::ClippedPrimitive> {
        self.time += 1.0 / 60.0;
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, self.points.into());
        let input = egui::RawInput { screen_rect: Some(rect), time: Some(self.time), ..Default::default() };
        let mut output = self.ctx.run_ui(input, |ui| self.inspector.ui(ui));
        let mut renderer = self.renderer.write();
        for (id, delta) in output.textures_delta.set.iter().flat_map(|(id, all)| all.iter().map(move |d| (id, d))) {
            renderer.update_texture(&self.gpu.device, &self.gpu.queue, *id, delta);
        }
        let jobs = self.ctx.tessellate(output.shapes, self.scale);
        // What is freed is still shown by this frame's shapes.
        self.gpu.queue.submit([]);
        for id in &output.textures_delta.free {
            renderer.free_texture(id);
        }
        output.textures_delta.clear();
        jobs
    }

    fn draw(&self, jobs: &[egui::ClippedPrimitive], [width, height]: [u32; 2]) -> Result<image::RgbaImage, Error> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("screenshot"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        let screen = ScreenDescriptor { size_in_pixels: [width, height], pixels_per_point: self.scale };
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut renderer = self.renderer.write();
        let buffers = renderer.update_buffers(device, queue, &mut encoder, jobs, &screen);
        {
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("screenshot"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            renderer.render(&mut pass.forget_lifetime(), jobs, &screen);
        }
        queue.submit(buffers.into_iter().chain([encoder.finish()]));
        let bytes = crate::device::block_on(Some(&self.gpu), self.gpu.read_rgba8(&texture))?;
        image::RgbaImage::from_raw(width, height, bytes)
            .ok_or_else(|| Error::failed("the screenshot came back in another size"))
    }
}
