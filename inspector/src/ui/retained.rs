//! The window's last frame, of which only what differs is drawn again: a GPU in software needs longer for the pixels of
//! a whole window than everything else takes.

mod tiles;

use std::collections::BTreeSet;

use egui::epaint::{Mesh, Primitive, WHITE_UV};
use egui::{ClippedPrimitive, Color32, Rect, TextureId, TexturesDelta};
use egui_wgpu::{Renderer, ScreenDescriptor};
use raystep_kernels::Gpu;

use tiles::Tiles;

/// A texture with the last frame.
#[derive(Default)]
pub struct Retained {
    last: Option<Last>,
    /// Textures whose contents were replaced since.
    replaced: BTreeSet<TextureId>,
}

struct Last {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    tiles: Tiles,
}

impl Retained {
    /// Notes which textures a frame replaces, and which of the inspector's
    /// [pictures](super::canvas::Canvas::take_redrawn) it has drawn again.
    pub fn note(&mut self, textures: &TexturesDelta, redrawn: &BTreeSet<TextureId>) {
        // A part of the font's texture is written only to add letters that were not drawn before.
        let is_replaced = |id: TextureId, is_whole: bool| is_whole || id != TextureId::default();
        let set = textures.set.iter().filter(|(id, all)| all.iter().any(|delta| is_replaced(**id, delta.is_whole())));
        self.replaced.extend(set.map(|(id, _)| id).chain(redrawn));
    }

    /// Draws what differs of a frame that egui tessellated, over a background. `renderer` draws in `format`, `size` is in
    /// pixels. `None` if nothing differs; otherwise the share of the frame that was drawn.
    #[expect(clippy::too_many_arguments)]
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        renderer: &mut Renderer,
        format: wgpu::TextureFormat,
        mut jobs: Vec<ClippedPrimitive>,
        background: Color32,
        size: [u32; 2],
        pixels_per_point: f32,
    ) -> Option<f32> {
        let screen = ScreenDescriptor { size_in_pixels: size, pixels_per_point };
        let points = size.map(|side| side as f32 / pixels_per_point);
        let whole = Rect::from_min_size(egui::Pos2::ZERO, points.into());
        jobs.insert(0, filled(whole, background));
        let last = match self.last.take() {
            Some(last) if [last.texture.width(), last.texture.height()] == size => last,
            _ => Last::new(&gpu.device, format, size),
        };
        let last = self.last.insert(last);
        let parts = last.tiles.changed(&jobs, pixels_per_point, &std::mem::take(&mut self.replaced));
        if parts.is_empty() {
            return None;
        }
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let buffers = renderer.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &jobs, &screen);
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("window"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &last.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        let mut pass = pass.forget_lifetime();
        let clips: Vec<Rect> = jobs.iter().map(|job| job.clip_rect).collect();
        for part in &parts {
            for (job, clip) in jobs.iter_mut().zip(&clips) {
                let both = clip.intersect(*part);
                job.clip_rect = if both.is_positive() { both } else { Rect::ZERO };
            }
            renderer.render(&mut pass, &jobs, &screen);
        }
        drop(pass);
        gpu.submit(buffers.into_iter().chain([encoder.finish()]));
        let area: f32 = parts.iter().map(|part| part.intersect(whole).area()).sum();
        Some(area / whole.area())
    }

    /// The last frame.
    #[must_use]
    pub fn texture(&self) -> Option<&wgpu::Texture> {
        self.last.as_ref().map(|last| &last.texture)
    }
}

impl Last {
    fn new(device: &wgpu::Device, format: wgpu::TextureFormat, [width, height]: [u32; 2]) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("last frame"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        Self { texture, view, tiles: Tiles::new([width, height]) }
    }
}

/// What is drawn again is drawn over this, as over a cleared texture.
fn filled(rect: Rect, color: Color32) -> ClippedPrimitive {
    let mut mesh = Mesh::default();
    mesh.add_rect_with_uv(rect, Rect::from_min_max(WHITE_UV, WHITE_UV), color);
    ClippedPrimitive { clip_rect: rect, primitive: Primitive::Mesh(mesh) }
}
