//! Streams as `rgba32uint` textures: a texel per ray, a component per layer, floats as bits.

use super::FragmentExecutor;
use crate::executor::gpu::readback::Readback;
use crate::executor::gpu::{Gpu, GpuError};
use crate::fragment::{MOST_LAYERS, TEXEL_BYTES};
use crate::plan::{DrawnPlan, Plan};
use crate::tables::stream::{Region, Stream, StreamData};

/// The format of every stream.
pub(super) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// Bytes per read-back, or a row if that is larger.
const TRIP_BYTES: u64 = 1 << 26;

/// The textures of a stream: two if a kernel both reads and writes it.
pub(super) struct Textures {
    pub(super) stream: Stream,
    textures: Vec<wgpu::Texture>,
    views: Vec<wgpu::TextureView>,
    /// Which of them holds its values.
    pub(super) holder: usize,
}

impl Textures {
    /// The texture that holds the values.
    pub(super) fn current(&self) -> &wgpu::Texture {
        &self.textures[self.holder]
    }

    /// The other one, or the only one.
    pub(super) fn other(&self) -> &wgpu::Texture {
        &self.textures[self.other_index()]
    }

    pub(super) fn other_index(&self) -> usize {
        (self.holder + 1) % self.textures.len()
    }

    pub(super) fn view(&self, index: usize) -> &wgpu::TextureView {
        &self.views[index]
    }
}

/// The textures of all streams of a run.
pub(super) struct StreamTextures(Vec<Textures>);

impl StreamTextures {
    pub(super) fn new(device: &wgpu::Device, plan: &Plan, drawn: &DrawnPlan) -> Self {
        let textures = |stream: Stream| {
            let count = if drawn.is_double(stream) { 2 } else { 1 };
            let label = plan.label(stream.name());
            let textures: Vec<_> = (0..count).map(|_| texture(device, &label, plan.width, plan.height)).collect();
            let views = textures.iter().map(|texture| texture.create_view(&Default::default())).collect();
            Textures { stream, textures, views, holder: 0 }
        };
        Self(plan.streams.iter().map(|planned| textures(planned.what)).collect())
    }

    pub(super) fn get(&self, stream: Stream) -> Option<&Textures> {
        self.0.iter().find(|textures| textures.stream == stream)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Textures> {
        self.0.iter()
    }

    /// Makes the other texture of a stream hold its values.
    pub(super) fn swap(&mut self, stream: Stream) {
        if let Some(textures) = self.0.iter_mut().find(|textures| textures.stream == stream) {
            textures.holder = textures.other_index();
        }
    }

    /// Names and sizes in bytes.
    pub(super) fn allocated(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        let bytes = |texture: &wgpu::Texture| TEXEL_BYTES * u64::from(texture.width()) * u64::from(texture.height());
        self.0.iter().map(move |all| (all.stream.name(), all.textures.iter().map(bytes).sum()))
    }

    /// Resets every stream to its unwritten value.
    pub(super) fn clear(&mut self, encoder: &mut wgpu::CommandEncoder) {
        for textures in &mut self.0 {
            textures.holder = 0;
            // Whole numbers below 2⁵³, as a colour takes them.
            let layer = |layer: usize| textures.stream.info().unwritten.get(layer).map_or(0.0, |&bits| f64::from(bits));
            let color = wgpu::Color { r: layer(0), g: layer(1), b: layer(2), a: layer(3) };
            let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(color), store: wgpu::StoreOp::Store };
            let target = wgpu::RenderPassColorAttachment {
                view: textures.view(0),
                depth_slice: None,
                resolve_target: None,
                ops,
            };
            encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("clear"),
                color_attachments: &[Some(target)],
                ..Default::default()
            });
        }
    }

    /// Replaces a stream's values. Returns false if there is no such stream or the size differs.
    pub(super) fn write(&self, gpu: &Gpu, data: &StreamData) -> bool {
        let Some(textures) = self.get(data.stream) else { return false };
        let texture = textures.current();
        let texels = texture.width() as usize * texture.height() as usize;
        let is_alike = (data.width, data.height) == (texture.width(), texture.height());
        if !is_alike || data.bits.len() != texels * data.stream.layers() {
            return false;
        }
        let mut packed = vec![[0u32; MOST_LAYERS]; texels];
        for layer in 0..data.stream.layers() {
            for (texel, &bits) in packed.iter_mut().zip(data.layer(layer)) {
                texel[layer] = bits;
            }
        }
        gpu.write_texture(texture.as_image_copy(), texture.size(), bytemuck::cast_slice(&packed));
        true
    }
}

/// A texture for a stream.
pub(super) fn texture(device: &wgpu::Device, label: &str, width: u32, height: u32) -> wgpu::Texture {
    use wgpu::TextureUsages as U;
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: U::RENDER_ATTACHMENT | U::TEXTURE_BINDING | U::COPY_SRC | U::COPY_DST,
        view_formats: &[],
    })
}

impl FragmentExecutor {
    /// A region of a stream; `None` if the plan left the stream out or the image has no such region.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn read_region(&self, stream: Stream, region: Region) -> Result<Option<StreamData>, GpuError> {
        let Region { x, y, width, height } = region;
        let Some(texture) = self.texture(stream).filter(|t| region.is_in(t.width(), t.height())) else {
            return Ok(None);
        };
        let row_bytes = (TEXEL_BYTES as u32 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let rows = (TRIP_BYTES / u64::from(row_bytes)).clamp(1, u64::from(height)) as u32;
        let buffer = self.readback_buffer(u64::from(row_bytes) * u64::from(rows)).await?;
        let texels = width as usize * height as usize;
        let mut bits = vec![0; texels * stream.layers()];
        for first in (0..height).step_by(rows as usize) {
            let count = rows.min(height - first);
            let scopes = self.gpu.push_scopes();
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo {
                    origin: wgpu::Origin3d { x, y: y + first, z: 0 },
                    ..texture.as_image_copy()
                },
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(row_bytes),
                        rows_per_image: Some(count),
                    },
                },
                wgpu::Extent3d { width, height: count, depth_or_array_layers: 1 },
            );
            self.gpu.submit([encoder.finish()]);
            let bytes = u64::from(row_bytes) * u64::from(count);
            let readback = Readback::start(&self.gpu, buffer.clone(), bytes);
            self.gpu.pop_scopes(scopes).await?;
            let mut texel = first as usize * width as usize;
            let take = |bytes: &[u8]| {
                for row in bytes.chunks_exact(row_bytes as usize) {
                    for packed in row[..TEXEL_BYTES as usize * width as usize].chunks_exact(TEXEL_BYTES as usize) {
                        for (layer, word) in packed.chunks_exact(4).take(stream.layers()).enumerate() {
                            bits[layer * texels + texel] = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
                        }
                        texel += 1;
                    }
                }
            };
            readback.finish(bytes, take).await?;
        }
        Ok(Some(StreamData { stream, width, height, bits }))
    }

    /// One ray's texels in several streams, one word per layer. `None` if the plan left one of them out or the image has
    /// no such pixel.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn read_texels(&self, streams: &[Stream], x: u32, y: u32) -> Result<Option<Vec<Vec<u32>>>, GpuError> {
        let textures: Option<Vec<_>> = streams.iter().map(|&stream| self.texture(stream)).collect();
        let Some(textures) = textures.filter(|_| x < self.plan.width && y < self.plan.height) else { return Ok(None) };
        let bytes = TEXEL_BYTES * streams.len() as u64;
        if bytes == 0 {
            return Ok(Some(Vec::new()));
        }
        let buffer = self.readback_buffer(bytes).await?;
        let scopes = self.gpu.push_scopes();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (index, texture) in (0..).zip(textures) {
            let offset = TEXEL_BYTES * index;
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z: 0 }, ..texture.as_image_copy() },
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout { offset, bytes_per_row: None, rows_per_image: None },
                },
                wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            );
        }
        self.gpu.submit([encoder.finish()]);
        let readback = Readback::start(&self.gpu, buffer, bytes);
        self.gpu.pop_scopes(scopes).await?;
        let read = |bytes: &[u8]| {
            let texels = bytes.chunks_exact(TEXEL_BYTES as usize);
            let words = |texel: &[u8], layers: usize| {
                texel.chunks_exact(4).take(layers).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect()
            };
            texels.zip(streams).map(|(texel, stream)| words(texel, stream.layers())).collect()
        };
        readback.finish(bytes, read).await.map(Some)
    }

    async fn readback_buffer(&self, size: u64) -> Result<wgpu::Buffer, GpuError> {
        self.gpu.health()?;
        let scopes = self.gpu.push_scopes();
        let buffer = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(&self.plan.label("readback")),
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        self.gpu.pop_scopes(scopes).await?;
        Ok(buffer)
    }
}
