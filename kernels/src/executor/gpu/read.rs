//! Reads streams back from the GPU: whole, a region, or one ray's texels of many streams at once.

use super::{GpuError, GpuExecutor, StreamTexture};
use crate::executor::gpu::readback::Readback;
use crate::tables::stream::{Region, Stream, StreamData};

/// Bytes per read-back, or one layer if that is larger: a stream may be larger than the largest buffer.
const TRIP_BYTES: u64 = 1 << 26;

/// Distance in bytes between texels in a buffer of single texels. WebGPU requires a multiple of a texel's size.
const TEXEL_BYTES: u64 = 4;

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> + '_ {
    bytes.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]))
}

impl GpuExecutor {
    /// The values of a stream, once the GPU has finished all submitted work. `None` if the plan left it out.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn read(&self, stream: Stream) -> Result<Option<StreamData>, GpuError> {
        let Some(texture) = self.texture(stream) else { return Ok(None) };
        let region = Region { x: 0, y: 0, width: texture.width(), height: texture.height() };
        self.read_region(stream, region).await
    }

    /// A region of a stream; `None` if the plan left the stream out or the image has no such region.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn read_region(&self, stream: Stream, region: Region) -> Result<Option<StreamData>, GpuError> {
        let Region { x, y, width, height } = region;
        let Some(texture) = self.texture(stream).filter(|t| region.is_in(t.width(), t.height())) else {
            return Ok(None);
        };
        let layers = stream.layers() as u32;
        let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let layer_bytes = u64::from(row_bytes) * u64::from(height);
        let at_once = (TRIP_BYTES / layer_bytes).clamp(1, u64::from(layers)) as u32;
        let buffer = self.readback_buffer(layer_bytes * u64::from(at_once)).await?;
        let mut bits = Vec::with_capacity(layers as usize * width as usize * height as usize);
        for first in (0..layers).step_by(at_once as usize) {
            let count = at_once.min(layers - first);
            let scopes = self.gpu.push_scopes();
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            encoder.copy_texture_to_buffer(
                texture.copy_at(x, y, first),
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(row_bytes),
                        rows_per_image: Some(height),
                    },
                },
                wgpu::Extent3d { width, height, depth_or_array_layers: count },
            );
            self.gpu.submit([encoder.finish()]);
            let bytes = layer_bytes * u64::from(count);
            let readback = Readback::start(&self.gpu, buffer.clone(), bytes);
            self.gpu.pop_scopes(scopes).await?;
            let take = |bytes: &[u8]| {
                for row in bytes.chunks_exact(row_bytes as usize) {
                    bits.extend(words(&row[..4 * width as usize]));
                }
            };
            readback.finish(bytes, take).await?;
        }
        Ok(Some(StreamData { stream, width, height, bits }))
    }

    /// One ray's texels in several streams, one word per layer, in one submission and one read-back. `None` if the plan
    /// left one of them out or the image has no such pixel.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn read_texels(&self, streams: &[Stream], x: u32, y: u32) -> Result<Option<Vec<Vec<u32>>>, GpuError> {
        let textures: Option<Vec<_>> = streams.iter().map(|&s| Some((s, self.texture(s)?))).collect();
        let is_there = |textures: &Vec<(Stream, &StreamTexture)>| {
            textures.iter().all(|(_, texture)| x < texture.width() && y < texture.height())
        };
        let Some(textures) = textures.filter(is_there) else { return Ok(None) };
        let bytes = TEXEL_BYTES * streams.iter().map(|s| s.layers() as u64).sum::<u64>();
        if bytes == 0 {
            return Ok(Some(Vec::new()));
        }
        let buffer = self.readback_buffer(bytes).await?;
        let scopes = self.gpu.push_scopes();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut offset = 0;
        for (stream, texture) in textures {
            // Layers copied together would be a row apart, at least 256 bytes.
            for z in 0..stream.layers() as u32 {
                encoder.copy_texture_to_buffer(
                    texture.copy_at(x, y, z),
                    wgpu::TexelCopyBufferInfo {
                        buffer: &buffer,
                        layout: wgpu::TexelCopyBufferLayout { offset, bytes_per_row: None, rows_per_image: None },
                    },
                    wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
                );
                offset += TEXEL_BYTES;
            }
        }
        self.gpu.submit([encoder.finish()]);
        let readback = Readback::start(&self.gpu, buffer, bytes);
        self.gpu.pop_scopes(scopes).await?;
        let read = |bytes: &[u8]| {
            let mut words = words(bytes);
            streams.iter().map(|s| words.by_ref().take(s.layers()).collect()).collect()
        };
        readback.finish(bytes, read).await.map(Some)
    }

    async fn readback_buffer(&self, size: u64) -> Result<wgpu::Buffer, GpuError> {
        self.gpu.health()?;
        let scopes = self.gpu.push_scopes();
        let buffer = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(&format!("{}.readback", self.plan.program.name)),
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        self.gpu.pop_scopes(scopes).await?;
        Ok(buffer)
    }
}
