//! Images of the window, drawn with our own device.

use std::sync::{Arc, Mutex};

use egui::mutex::RwLock;
use egui_kittest::TestRenderer;
use egui_wgpu::Renderer;
use raystep_inspector::draw::picture::FORMAT;
use raystep_inspector::ui::retained::Retained;
use raystep_inspector::ui::{background, offscreen};
use raystep_kernels::Gpu;

use super::Stage;
use crate::ui::adapter::block_on;

impl Stage {
    /// The window without its texts, as an image.
    pub(crate) fn draw_without_text(&self) -> image::RgbaImage {
        fn without(shape: &egui::Shape) -> egui::Shape {
            match shape {
                egui::Shape::Text(_) => egui::Shape::Noop,
                egui::Shape::Vec(shapes) => egui::Shape::Vec(shapes.iter().map(without).collect()),
                other => other.clone(),
            }
        }
        let shapes = self.harness.output().shapes.iter();
        let shapes = shapes.map(|clipped| egui::epaint::ClippedShape { shape: without(&clipped.shape), ..*clipped });
        let shapes = shapes.collect();
        draw(&self.gpu, &self.renderer, &self.harness.ctx, shapes).expect("it can be drawn")
    }

    /// The window, drawn as a whole.
    pub(crate) fn image(&self) -> image::RgbaImage {
        let shapes = self.harness.output().shapes.clone();
        draw(&self.gpu, &self.renderer, &self.harness.ctx, shapes).expect("it can be drawn")
    }

    /// The window, drawn where it differs from the one that was drawn so before; and the share that was drawn.
    pub(crate) fn image_over_the_last(&self) -> (image::RgbaImage, f32) {
        let ctx = &self.harness.ctx;
        let points = ctx.pixels_per_point();
        let jobs = ctx.tessellate(self.harness.output().shapes.clone(), points);
        let mut retained = self.retained.lock().expect("not poisoned");
        retained.note(&egui::TexturesDelta::default(), &self.harness.state().take_redrawn());
        let mut renderer = self.renderer.write();
        let drawn = retained.draw(&self.gpu, &mut renderer, FORMAT, jobs, background(ctx), size_in_pixels(ctx), points);
        let texture = retained.texture().expect("a frame");
        let texels = block_on(&self.gpu, self.gpu.read_rgba8(texture)).expect("it can be read");
        let image = image::RgbaImage::from_raw(texture.width(), texture.height(), texels).expect("of this size");
        (image, drawn.unwrap_or(0.0))
    }
}

/// Draws with our own device.
pub(super) struct Painter {
    pub(super) gpu: Arc<Gpu>,
    pub(super) renderer: Arc<RwLock<Renderer>>,
    pub(super) retained: Arc<Mutex<Retained>>,
}

impl TestRenderer for Painter {
    fn handle_delta(&mut self, delta: &mut egui::TexturesDelta) {
        self.retained.lock().expect("not poisoned").note(delta, &Default::default());
        let mut renderer = self.renderer.write();
        for (id, images) in delta.set.drain() {
            for image in images {
                renderer.update_texture(&self.gpu.device, &self.gpu.queue, id, &image);
            }
        }
        for id in delta.free.drain() {
            renderer.free_texture(&id);
        }
    }

    fn render(&mut self, ctx: &egui::Context, output: &egui::FullOutput) -> Result<image::RgbaImage, String> {
        draw(&self.gpu, &self.renderer, ctx, output.shapes.clone())
    }
}

fn size_in_pixels(ctx: &egui::Context) -> [u32; 2] {
    let size = ctx.content_rect().size() * ctx.pixels_per_point();
    [size.x, size.y].map(|side| side.round().max(1.0) as u32)
}

fn draw(
    gpu: &Arc<Gpu>,
    renderer: &RwLock<Renderer>,
    ctx: &egui::Context,
    shapes: Vec<egui::epaint::ClippedShape>,
) -> Result<image::RgbaImage, String> {
    let points = ctx.pixels_per_point();
    let jobs = ctx.tessellate(shapes, points);
    let drawn = offscreen::draw(gpu, renderer, &jobs, background(ctx), size_in_pixels(ctx), points);
    block_on(gpu, drawn).map_err(|e| e.to_string())
}
