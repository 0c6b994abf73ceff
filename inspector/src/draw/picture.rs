//! Textures to render into.

/// The format of every picture. egui blends sRGB-encoded colours directly and expects this format of its textures, so
/// colours are written encoded too.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A buffer with these bytes, a multiple of four. It is never mapped, since mapping panics on a lost device.
pub(super) fn filled(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let usage = usage | wgpu::BufferUsages::COPY_DST;
    let size = contents.len() as u64;
    let buffer =
        device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false });
    queue.write_buffer(&buffer, 0, contents);
    buffer
}

/// A texture to render into, for display or for copying to a file. At least one pixel, and at most what the device
/// supports.
#[must_use]
pub fn picture(device: &wgpu::Device, size: [u32; 2]) -> wgpu::Texture {
    let most = device.limits().max_texture_dimension_2d;
    let [width, height] = size.map(|n| n.clamp(1, most));
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
