//! Draws the window into an image, by egui's own renderer.

use std::sync::Arc;

use egui::mutex::RwLock;
use egui_wgpu::{Renderer, ScreenDescriptor};
use image::RgbaImage;
use raystep_kernels::{Gpu, GpuError};

use crate::draw::picture::picture;

/// Draws what egui tessellated; its textures are in `renderer`, which draws in
/// [`FORMAT`](crate::draw::picture::FORMAT), over a background. `size` is in pixels.
///
/// # Errors
/// Where the device is lost or refuses.
pub async fn draw(
    gpu: &Arc<Gpu>,
    renderer: &RwLock<Renderer>,
    jobs: &[egui::ClippedPrimitive],
    background: egui::Color32,
    size: [u32; 2],
    pixels_per_point: f32,
) -> Result<RgbaImage, GpuError> {
    let texture = picture(&gpu.device, size);
    let (width, height) = (texture.width(), texture.height());
    submit(gpu, &mut renderer.write(), jobs, background, &texture, pixels_per_point);
    let texels = gpu.read_rgba8(&texture).await?;
    RgbaImage::from_raw(width, height, texels)
        .ok_or_else(|| GpuError::Readback("the image was returned in another size".into()))
}

/// The same into a texture of the format that `renderer` draws in, without waiting for it.
pub fn submit(
    gpu: &Gpu,
    renderer: &mut Renderer,
    jobs: &[egui::ClippedPrimitive],
    background: egui::Color32,
    texture: &wgpu::Texture,
    pixels_per_point: f32,
) {
    let screen = ScreenDescriptor { size_in_pixels: [texture.width(), texture.height()], pixels_per_point };
    let [r, g, b, a] = background.to_normalized_gamma_f32().map(f64::from);
    let color = wgpu::Color { r, g, b, a };
    let view = texture.create_view(&Default::default());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let buffers = renderer.update_buffers(&gpu.device, &gpu.queue, &mut encoder, jobs, &screen);
    let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("window"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(color), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
    renderer.render(&mut pass.forget_lifetime(), jobs, &screen);
    gpu.submit(buffers.into_iter().chain([encoder.finish()]));
}
