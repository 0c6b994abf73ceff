//! Textures with the streams of the CPU reference, for drawing.

use raystep_kernels::executor::gpu::{StreamTexture, stream_format};
use raystep_kernels::{Gpu, Renderer, Stream, StreamData};

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
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_texture(source.as_image_copy(), copy.as_image_copy(), source.size());
    gpu.submit([encoder.finish()]);
    copy
}

/// Copies a stream's values into such a texture.
pub(super) fn fill(gpu: &Gpu, texture: &StreamTexture, data: &StreamData) {
    let (width, height, layers) = (data.width, data.height, data.stream.layers() as u32);
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    gpu.write_texture(texture.as_image_copy(), size, bytemuck::cast_slice(&data.bits));
}

/// The textures of all streams whose elements are counted: the run's own on a GPU, otherwise `copies`, which are made
/// anew where a size has changed.
pub(super) fn textures(
    gpu: &Gpu,
    renderer: &Renderer,
    copies: &mut Vec<(Stream, StreamTexture)>,
) -> Vec<(Stream, StreamTexture)> {
    let streams = renderer.plan().streams.iter().map(|planned| planned.what);
    if renderer.adapter().is_some() {
        return streams.filter_map(|stream| Some((stream, renderer.texture(stream)?))).collect();
    }
    let copy = |stream: Stream| {
        let size = renderer.size(stream.info().elements)?;
        let is_same = |texture: &StreamTexture| (texture.width(), texture.height()) == (size.width, size.height);
        let old = copies.iter().find(|(s, texture)| *s == stream && is_same(texture));
        let texture = old.map(|(_, texture)| texture.clone());
        Some((stream, texture.unwrap_or_else(|| stream_copy(gpu, stream, size.width, size.height))))
    };
    let now: Vec<_> = streams.filter_map(copy).collect();
    copies.clone_from(&now);
    now
}
