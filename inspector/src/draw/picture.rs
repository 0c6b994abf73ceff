//! Textures that pictures are drawn into.

/// The format of every picture. egui blends sRGB-encoded colours as they are and wants this for its textures, so colours
/// are written encoded too.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A buffer that holds these bytes, a multiple of four. Nothing of it is mapped, which on a lost device is a panic.
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

/// A texture to draw a picture into: to be shown by a panel, or copied to a file. Of at least one pixel, and of no more
/// than the device can hold.
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
