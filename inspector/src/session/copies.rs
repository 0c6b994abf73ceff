//! Textures with copies of streams, for drawing: of the CPU reference, and of WebGL, to which a texture with one layer is no
//! array.

use raystep_kernels::executor::gpu::{StreamTexture, stream_format};
use raystep_kernels::{Gpu, RenderError, Renderer, Stream, StreamData};

use super::Session;
use crate::draw::stream::drawable;

/// The bit of the stream at an index, among those that are drawn or filled.
pub(super) fn bit(index: usize) -> u64 {
    1 << index.min(63)
}

/// A texture like a stream's own, to draw from.
pub(super) fn stream_copy(gpu: &Gpu, stream: Stream, width: u32, height: u32) -> StreamTexture {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: stream.layers() as u32 };
    drawable(&gpu.device, stream.name(), stream_format(stream), size)
}

/// A texture like the one that holds a stream, with a copy of it.
pub(super) fn copy_of(gpu: &Gpu, label: &str, source: &StreamTexture) -> StreamTexture {
    let copy = drawable(&gpu.device, label, source.format(), source.size());
    copy_into(gpu, source, &copy);
    copy
}

/// Copies a texture into such a one.
fn copy_into(gpu: &Gpu, source: &StreamTexture, copy: &StreamTexture) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_texture(source.as_image_copy(), copy.as_image_copy(), source.size());
    gpu.submit([encoder.finish()]);
}

impl Session {
    /// Copies a stream's values into one of the [`textures`].
    pub(super) async fn copy_stream(
        &self,
        gpu: &Gpu,
        stream: Stream,
        texture: &StreamTexture,
    ) -> Result<(), RenderError> {
        match self.renderer().texture(stream) {
            Some(source) => copy_into(gpu, &source, texture),
            None => fill(gpu, texture, &self.stream(stream).await?),
        }
        Ok(())
    }
}

/// Copies a stream's values into such a texture.
pub(super) fn fill(gpu: &Gpu, texture: &StreamTexture, data: &StreamData) {
    let (width, height, layers) = (data.width, data.height, data.stream.layers() as u32);
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    gpu.write_texture(texture.as_image_copy(), size, bytemuck::cast_slice(&data.bits));
}

/// The textures of all streams whose elements are counted: the run's own on a GPU that computes, otherwise `copies`, which
/// are made anew where a size has changed.
pub(super) fn textures(
    gpu: &Gpu,
    renderer: &Renderer,
    copies: &mut Vec<(Stream, StreamTexture)>,
) -> Vec<(Stream, StreamTexture)> {
    let streams = renderer.plan().streams.iter().map(|planned| planned.what);
    if renderer.adapter().is_some_and(|gpu| gpu.computes) {
        return streams.filter_map(|stream| Some((stream, renderer.texture(stream)?))).collect();
    }
    let copy = |stream: Stream| {
        let size = renderer.size(stream.info().elements)?;
        let is_same = |texture: &StreamTexture| (texture.width(), texture.height()) == (size.width, size.height);
        let old = copies.iter().find(|(s, texture)| *s == stream && is_same(texture));
        let new = || match renderer.texture(stream) {
            Some(source) => drawable(&gpu.device, stream.name(), source.format(), source.size()),
            None => stream_copy(gpu, stream, size.width, size.height),
        };
        Some((stream, old.map_or_else(new, |(_, texture)| texture.clone())))
    };
    let now: Vec<_> = streams.filter_map(copy).collect();
    copies.clone_from(&now);
    now
}
