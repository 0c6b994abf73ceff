//! Reads images back from the GPU.

use std::sync::Arc;

use super::{Gpu, GpuError};
use crate::executor::gpu::readback::Readback;

impl Gpu {
    /// The texels of a texture with four bytes per texel, row by row from the top, once the GPU has drawn it.
    ///
    /// # Errors
    /// If the device is lost or refuses: the texture must allow copies from it.
    pub async fn read_rgba8(self: &Arc<Self>, texture: &wgpu::Texture) -> Result<Vec<u8>, GpuError> {
        self.health()?;
        let (width, height) = (texture.width(), texture.height());
        let pitch = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(pitch) * u64::from(height);
        let scopes = self.push_scopes();
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: bytes,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(pitch),
                    rows_per_image: Some(height),
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.submit([encoder.finish()]);
        let readback = Readback::start(self, buffer, bytes);
        self.pop_scopes(scopes).await?;
        let rows =
            |all: &[u8]| all.chunks_exact(pitch as usize).flat_map(|row| &row[..4 * width as usize]).copied().collect();
        readback.finish(bytes, rows).await
    }
}
