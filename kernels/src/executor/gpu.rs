//! Passes on a wgpu adapter. Nothing here blocks: what comes back from the GPU is a future.

mod device;
mod pipelines;

use std::sync::Arc;

use wgpu::util::DeviceExt as _;

pub use device::{AdapterChoice, AdapterSummary, Gpu, GpuError, adapters};
use pipelines::{Counting, Pipelines};

use super::PassResult;
use super::readback::Readback;
use crate::kernel::Kernel;
use crate::plan::{COUNT_SLOT_BYTES, COUNT_SLOTS, Plan};
use crate::scene_data::SceneData;
use crate::shared::constants::WORKGROUP;
use crate::state::{COUNT, StateCounts};
use crate::stream::{Stream, StreamData, Texel};

/// Runs kernels over the rays of a plan.
pub struct GpuExecutor {
    gpu: Arc<Gpu>,
    width: u32,
    height: u32,
    streams: Vec<(Stream, wgpu::Texture)>,
    buffers: Vec<(&'static str, wgpu::Buffer)>,
    pipelines: Pipelines,
    counting: Counting,
    timers: Option<Timers>,
}

struct Timers {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    copy: wgpu::Buffer,
    period_ns: f64,
}

/// Most passes of one submission: one slot each for counts.
pub const MOST_PASSES: usize = COUNT_SLOTS as usize;

impl GpuExecutor {
    /// Allocates the plan's streams and buffers, uploads the buffers, compiles the variants. Errors of
    /// validation and out-of-memory are caught, not thrown as panics.
    ///
    /// # Errors
    /// Where the device refuses or is lost.
    pub async fn new(gpu: Arc<Gpu>, plan: &Plan, data: &SceneData, timed: bool) -> Result<Self, GpuError> {
        gpu.health()?;
        let device = &gpu.device;
        let scopes = gpu.push_scopes();
        let streams: Vec<_> = plan.streams.iter().map(|s| (s.what, stream_texture(device, plan, s.what))).collect();
        let mut buffers = Vec::new();
        for planned in &plan.buffers {
            let Some(contents) = data.bytes(planned.what) else { continue };
            let is_uniform = crate::buffer::info(planned.what).is_some_and(|b| b.is_uniform);
            let kind = if is_uniform { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
            let usage = kind | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
            let descriptor = wgpu::util::BufferInitDescriptor { label: Some(planned.what), contents, usage };
            buffers.push((planned.what, device.create_buffer_init(&descriptor)));
        }
        let pipelines = Pipelines::new(device, &plan.variants, &streams, &buffers)?;
        let state = streams.iter().find(|(s, _)| *s == Stream::State).map(|(_, t)| t);
        let counting = Counting::new(device, state.ok_or(GpuError::Missing("state"))?);
        let timers = gpu.timestamp_period_ns.filter(|_| timed).map(|period_ns| Timers::new(device, period_ns));
        let executor =
            Self { gpu, width: plan.width, height: plan.height, streams, buffers, pipelines, counting, timers };
        executor.clear();
        executor.gpu.pop_scopes(scopes).await?;
        Ok(executor)
    }

    /// The device in use.
    #[must_use]
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// A stream's own texture: a 2D array, one layer a component.
    #[must_use]
    pub fn texture(&self, stream: Stream) -> Option<&wgpu::Texture> {
        self.streams.iter().find(|(s, _)| *s == stream).map(|(_, t)| t)
    }

    /// A buffer of scene data, by name.
    #[must_use]
    pub fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.buffers.iter().find(|(n, _)| *n == name).map(|(_, b)| b)
    }

    /// Names and bytes of everything that is allocated, as the device has it.
    #[must_use]
    pub fn allocated(&self) -> Vec<(&'static str, u64)> {
        let bytes =
            |t: &wgpu::Texture| 4 * u64::from(t.width()) * u64::from(t.height()) * u64::from(t.depth_or_array_layers());
        let streams = self.streams.iter().map(|(s, t)| (s.name(), bytes(t)));
        let buffers = self.buffers.iter().map(|(n, b)| (*n, b.size()));
        let counts = [("live_counts", self.counting.slots.size()), ("live_counts_copy", self.counting.copy.size())];
        streams.chain(buffers).chain(counts).collect()
    }

    /// Every stream to its unwritten value.
    pub fn clear(&self) {
        // Some rows at a time: a stream may be larger than what one would stage for it at once.
        let rows = ((1 << 20) / self.width).clamp(1, self.height);
        for (stream, texture) in &self.streams {
            for (layer, &bits) in stream.info().unwritten.iter().enumerate() {
                let texels = vec![bits; (rows * self.width) as usize];
                for first in (0..self.height).step_by(rows as usize) {
                    let height = rows.min(self.height - first);
                    let origin = wgpu::Origin3d { x: 0, y: first, z: layer as u32 };
                    let size = wgpu::Extent3d { width: self.width, height, depth_or_array_layers: 1 };
                    self.upload(texture, origin, size, &texels[..(height * self.width) as usize]);
                }
            }
        }
    }

    fn upload(&self, texture: &wgpu::Texture, origin: wgpu::Origin3d, size: wgpu::Extent3d, texels: &[u32]) {
        self.gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * size.width),
                rows_per_image: Some(size.height),
            },
            size,
        );
    }

    /// Replaces a stream. False where the plan left it out or the size differs.
    pub fn write(&self, data: &StreamData) -> bool {
        let Some(texture) = self.texture(data.stream) else { return false };
        let layers = data.stream.layers() as u32;
        let texels = self.width as usize * self.height as usize * layers as usize;
        if (data.width, data.height) != (self.width, self.height) || data.bits.len() != texels {
            return false;
        }
        let size = wgpu::Extent3d { width: self.width, height: self.height, depth_or_array_layers: layers };
        self.upload(texture, wgpu::Origin3d::ZERO, size, &data.bits);
        true
    }

    /// Submits passes, at most [`MOST_PASSES`], and resolves to what each of them did.
    ///
    /// # Errors
    /// Where the device is lost or refuses.
    pub async fn run(&mut self, passes: &[Kernel]) -> Result<Vec<PassResult>, GpuError> {
        self.gpu.health()?;
        let passes = &passes[..passes.len().min(MOST_PASSES)];
        let count = passes.len() as u64;
        if passes.is_empty() {
            return Ok(Vec::new());
        }
        let scopes = self.gpu.push_scopes();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.counting.slots, 0, Some(count * COUNT_SLOT_BYTES));
        for (slot, &kernel) in passes.iter().enumerate() {
            self.encode(&mut encoder, kernel, slot as u32)?;
        }
        encoder.copy_buffer_to_buffer(&self.counting.slots, 0, &self.counting.copy, 0, count * COUNT_SLOT_BYTES);
        if let Some(timers) = &self.timers {
            encoder.resolve_query_set(&timers.set, 0..2 * count as u32, &timers.resolved, 0);
            encoder.copy_buffer_to_buffer(&timers.resolved, 0, &timers.copy, 0, 16 * count);
        }
        self.gpu.queue.submit([encoder.finish()]);
        let counts = Readback::start(&self.gpu, self.counting.copy.clone(), count * COUNT_SLOT_BYTES);
        let times = self.timers.as_ref().map(|t| Readback::start(&self.gpu, t.copy.clone(), 16 * count));
        self.gpu.pop_scopes(scopes).await?;

        let counts = counts.finish(count * COUNT_SLOT_BYTES, read_counts).await?;
        let period = self.timers.as_ref().map_or(1.0, |t| t.period_ns);
        let times = match times {
            Some(times) => times.finish(16 * count, |bytes| read_times(bytes, period)).await?,
            None => vec![(None, None); passes.len()],
        };
        let results = passes.iter().zip(counts).zip(times);
        Ok(results
            .map(|((&kernel, counts), (begin_ns, duration_ns))| PassResult { kernel, counts, begin_ns, duration_ns })
            .collect())
    }

    fn encode(&self, encoder: &mut wgpu::CommandEncoder, kernel: Kernel, slot: u32) -> Result<(), GpuError> {
        let pipeline = self.pipelines.get(kernel).ok_or(GpuError::Missing(kernel.name()))?;
        let timestamp_writes = self.timers.as_ref().map(|t| wgpu::ComputePassTimestampWrites {
            query_set: &t.set,
            beginning_of_pass_write_index: Some(2 * slot),
            end_of_pass_write_index: Some(2 * slot + 1),
        });
        {
            let descriptor = wgpu::ComputePassDescriptor { label: Some(kernel.name()), timestamp_writes };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(&pipeline.pipeline);
            for (group, bind_group) in pipeline.groups.iter().enumerate() {
                pass.set_bind_group(group as u32, bind_group, &[]);
            }
            pass.dispatch_workgroups(self.width.div_ceil(WORKGROUP), self.height.div_ceil(WORKGROUP), 1);
        }
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("count"), timestamp_writes: None });
        pass.set_pipeline(&self.counting.pipeline);
        pass.set_bind_group(0, &self.counting.group, &[slot * COUNT_SLOT_BYTES as u32]);
        pass.dispatch_workgroups(self.width.div_ceil(16), self.height.div_ceil(16), 1);
        Ok(())
    }

    /// The values of a stream, once the GPU has finished what was submitted. `None` where the plan left it out.
    ///
    /// # Errors
    /// Where the device is lost or refuses.
    pub async fn read(&self, stream: Stream) -> Result<Option<StreamData>, GpuError> {
        let full = (0, 0, self.width, self.height);
        let Some(bits) = self.read_region(stream, full).await? else { return Ok(None) };
        Ok(Some(StreamData { stream, width: self.width, height: self.height, bits }))
    }

    /// One ray's texel in a stream; `None` where the plan left the stream out or the image has no such pixel.
    ///
    /// # Errors
    /// Where the device is lost or refuses.
    pub async fn read_texel(&self, stream: Stream, x: u32, y: u32) -> Result<Option<Vec<u32>>, GpuError> {
        if x >= self.width || y >= self.height {
            return Ok(None);
        }
        self.read_region(stream, (x, y, 1, 1)).await
    }

    async fn read_region(&self, stream: Stream, region: (u32, u32, u32, u32)) -> Result<Option<Vec<u32>>, GpuError> {
        let (x, y, width, height) = region;
        let Some(texture) = self.texture(stream) else { return Ok(None) };
        self.gpu.health()?;
        let layers = stream.layers() as u32;
        let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let layer_bytes = u64::from(row_bytes) * u64::from(height);
        let scopes = self.gpu.push_scopes();
        let buffer = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            // One layer at a time: a stream may be larger than the largest buffer.
            size: layer_bytes,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        self.gpu.pop_scopes(scopes).await?;
        let mut bits = Vec::with_capacity((layers * width * height) as usize);
        for layer in 0..layers {
            let scopes = self.gpu.push_scopes();
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z: layer }, ..texture.as_image_copy() },
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(row_bytes),
                        rows_per_image: Some(height),
                    },
                },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
            self.gpu.queue.submit([encoder.finish()]);
            let readback = Readback::start(&self.gpu, buffer.clone(), layer_bytes);
            self.gpu.pop_scopes(scopes).await?;
            readback
                .finish(layer_bytes, |bytes| {
                    for row in bytes.chunks_exact(row_bytes as usize) {
                        let words = row[..4 * width as usize].chunks_exact(4);
                        bits.extend(words.map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])));
                    }
                })
                .await?;
        }
        Ok(Some(bits))
    }
}

impl Timers {
    fn new(device: &wgpu::Device, period_ns: f64) -> Self {
        let count = 2 * MOST_PASSES as u32;
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 8 * u64::from(count),
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as U;
        Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass timers"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: buffer("pass timers", U::QUERY_RESOLVE | U::COPY_SRC),
            copy: buffer("pass timers, copy", U::COPY_DST | U::MAP_READ),
            period_ns,
        }
    }
}

fn read_counts(bytes: &[u8]) -> Vec<StateCounts> {
    bytes
        .chunks_exact(COUNT_SLOT_BYTES as usize)
        .map(|slot| {
            let word = |i: usize| u32::from_le_bytes([slot[4 * i], slot[4 * i + 1], slot[4 * i + 2], slot[4 * i + 3]]);
            let mut counts = [0; COUNT];
            counts.iter_mut().enumerate().for_each(|(i, c)| *c = word(i));
            counts
        })
        .collect()
}

/// Begin and duration of each pass. An end before its begin, or 0, is not a time.
fn read_times(bytes: &[u8], period_ns: f64) -> Vec<(Option<u64>, Option<u64>)> {
    let ticks: Vec<u64> =
        bytes.chunks_exact(8).map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])).collect();
    let ns = |ticks: u64| (ticks as f64 * period_ns) as u64;
    ticks
        .chunks_exact(2)
        .map(|t| match (t[0], t[1]) {
            (0, _) | (_, 0) => (None, None),
            (begin, end) if end < begin => (Some(ns(begin)), None),
            (begin, end) => (Some(ns(begin)), Some(ns(end - begin))),
        })
        .collect()
}

fn stream_texture(device: &wgpu::Device, plan: &Plan, stream: Stream) -> wgpu::Texture {
    use wgpu::TextureUsages as U;
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(stream.name()),
        size: wgpu::Extent3d { width: plan.width, height: plan.height, depth_or_array_layers: stream.layers() as u32 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: stream_format(stream),
        usage: U::STORAGE_BINDING | U::TEXTURE_BINDING | U::COPY_SRC | U::COPY_DST,
        view_formats: &[],
    })
}

/// The texture format of a stream.
#[must_use]
pub fn stream_format(stream: Stream) -> wgpu::TextureFormat {
    match stream.info().texel {
        Texel::F32 => wgpu::TextureFormat::R32Float,
        Texel::U32 => wgpu::TextureFormat::R32Uint,
    }
}
