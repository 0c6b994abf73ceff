//! Textures with the streams of the CPU reference, for drawing.

use raystep_kernels::executor::gpu::stream_format;
use raystep_kernels::{Gpu, Stream, StreamData};

/// A texture like a stream's own, to draw from.
pub(super) fn stream_copy(gpu: &Gpu, stream: Stream, width: u32, height: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(stream.name()),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: stream.layers() as u32 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: stream_format(stream),
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Copies a stream's values into such a texture.
pub(super) fn fill(gpu: &Gpu, texture: &wgpu::Texture, data: &StreamData) {
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * data.width),
        rows_per_image: Some(data.height),
    };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&data.bits), layout, texture.size());
}
