//! Repeats a pass until its duration can be told, where the device's clock is coarse and every pass is timed.
//!
//! Before each repetition, everything that the pass writes is restored from copies that were made before its first run:
//! its streams, its counts and the lengths of the lists that it appends to. So the last repetition leaves what a single
//! run would have left. The rays in lists need not be restored: a pass reads only its own list, which it does not write,
//! and writes every entry that it appends. Timestamps are written around the pass only.
//!
//! Passes that take several dispatches or submissions (kernels launched in bands, and long lists), and those whose rays
//! are counted afterwards by another kernel, are not repeated. They are mostly long.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::books::{Books, Place};
use super::readback::Readback;
use super::rounding::{MOST_RUNS, Runs};
use super::stream_texture::bytes;
use super::timers::read_times;
use super::{GpuError, GpuExecutor, MOST_PASSES, StreamTexture};
use crate::program::Kernel;
use crate::tables::kernel::Launch;
use crate::tables::sizes::COUNT_SLOT_BYTES;
use crate::tables::stream::Stream;

/// Browsers may take the begin of a pass before the copies recorded before it are done: on Vulkan, a pass waits for them
/// only after that. So another pass waits for them, one without a time.
const WAIT: &str = "
@group(0) @binding(0) var<storage, read_write> waits: atomic<u32>;

@compute @workgroup_size(1)
fn wait() {
    atomicAdd(&waits, 1u);
}
";

const _: () = assert!(MOST_RUNS as usize <= MOST_PASSES, "each run has two timestamps");

/// Copies of what a pass writes.
pub(super) struct Repeater {
    streams: BTreeMap<Stream, wgpu::Texture>,
    /// The slots of a batch's only pass, one after the other.
    slots: wgpu::Buffer,
    waits: wgpu::Buffer,
    wait: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

impl Repeater {
    pub(super) fn new(device: &wgpu::Device, books: &Books) -> Self {
        use wgpu::BufferUsages as U;
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let label = Some("wait");
        let source = wgpu::ShaderSource::Wgsl(Cow::Borrowed(WAIT));
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let wait = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: label,
            compilation_options: Default::default(),
            cache: None,
        });
        let waits = buffer("waits", 4, U::STORAGE | U::COPY_DST);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &wait.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: waits.as_entire_binding() }],
        });
        let slots = buffer("slots, kept", books.slots().count() as u64 * COUNT_SLOT_BYTES, U::COPY_SRC | U::COPY_DST);
        Self { streams: BTreeMap::new(), slots, waits, wait, group }
    }

    /// Names and sizes in bytes of what it keeps.
    pub(super) fn allocated(&self) -> [(&'static str, u64); 2] {
        let kept = self.streams.values().map(|texture| bytes(texture.size()));
        [("kept", kept.sum()), ("slots_kept", self.slots.size())]
    }

    /// The buffers with slots, and where their first slot is kept.
    fn slots_of<'a>(&self, books: &'a Books) -> impl Iterator<Item = (u64, &'a wgpu::Buffer)> + use<'a> {
        (0..).step_by(COUNT_SLOT_BYTES as usize).zip(books.slots())
    }

    /// Makes what follows begin after the copies recorded so far.
    fn encode_wait(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.waits, 0, None);
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("wait"), timestamp_writes: None });
        pass.set_pipeline(&self.wait);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
    }
}

impl GpuExecutor {
    /// Of passes that can be submitted together, those that are: only the first if it may have to be repeated.
    pub(super) fn one_if_repeated<'a>(&self, passes: &'a [Kernel]) -> &'a [Kernel] {
        if self.repeater.is_some() { &passes[..passes.len().min(1)] } else { passes }
    }

    /// Makes room for copies of what a batch's only pass writes. Returns whether it can be repeated.
    pub(super) async fn can_repeat(&mut self, passes: &[Kernel]) -> Result<bool, GpuError> {
        let (&[kernel], Some(repeater)) = (passes, &self.repeater) else { return Ok(false) };
        let is_one_dispatch = kernel.info().launch != Launch::Bands && self.blocks_a_dispatch(kernel).is_none();
        if !is_one_dispatch || kernel.is_counted_anew(&self.plan.features) {
            return Ok(false);
        }
        let has_room = |(stream, texture): &(Stream, &StreamTexture)| {
            repeater.streams.get(stream).is_some_and(|copy| copy.size() == texture.size())
        };
        let missing: Vec<_> = self.written(kernel).filter(|written| !has_room(written)).collect();
        if missing.is_empty() {
            return Ok(true);
        }
        let scopes = self.gpu.push_scopes();
        let new: Vec<_> = missing.iter().map(|&(stream, texture)| (stream, self.room_for(stream, texture))).collect();
        match self.gpu.pop_scopes(scopes).await {
            // The run continues, and short passes are marked as such.
            Err(GpuError::OutOfMemory(_)) => self.repeater = None,
            made => {
                made?;
                self.repeater.iter_mut().for_each(|repeater| repeater.streams.extend(new.iter().cloned()));
            }
        }
        Ok(self.repeater.is_some())
    }

    /// The streams that a kernel writes.
    fn written(&self, kernel: Kernel) -> impl Iterator<Item = (Stream, &StreamTexture)> {
        let streams = self.pipelines.get(kernel).map_or(&[][..], |pipeline| &pipeline.writes);
        streams.iter().filter_map(|&stream| Some((stream, self.texture(stream)?)))
    }

    /// Copies what a pass of this kernel writes, before its first run.
    pub(super) fn encode_keep(&self, encoder: &mut wgpu::CommandEncoder, kernel: Kernel) {
        let Some(repeater) = &self.repeater else { return };
        for (stream, texture) in self.written(kernel) {
            if let Some(copy) = repeater.streams.get(&stream) {
                encoder.copy_texture_to_texture(texture.as_image_copy(), copy.as_image_copy(), texture.size());
            }
        }
        for (offset, slots) in repeater.slots_of(&self.books) {
            encoder.copy_buffer_to_buffer(slots, 0, &repeater.slots, offset, COUNT_SLOT_BYTES);
        }
        repeater.encode_wait(encoder);
    }

    /// Copies it back.
    fn encode_restore(&self, repeater: &Repeater, encoder: &mut wgpu::CommandEncoder, kernel: Kernel) {
        for (stream, texture) in self.written(kernel) {
            if let Some(copy) = repeater.streams.get(&stream) {
                encoder.copy_texture_to_texture(copy.as_image_copy(), texture.as_image_copy(), texture.size());
            }
        }
        for (offset, slots) in repeater.slots_of(&self.books) {
            encoder.copy_buffer_to_buffer(&repeater.slots, offset, slots, 0, COUNT_SLOT_BYTES);
        }
        repeater.encode_wait(encoder);
    }

    /// Repeats a batch's only pass until its duration can be told, or too much time has passed.
    pub(super) async fn repeat(&self, kernel: Kernel, place: &Place, runs: &mut Runs) -> Result<(), GpuError> {
        let (Some(repeater), Some(timers)) = (&self.repeater, &self.timers) else { return Ok(()) };
        let label = self.pipelines.get(kernel).map(|pipeline| pipeline.label.as_str());
        loop {
            let more = runs.more();
            if more == 0 {
                return Ok(());
            }
            let scopes = self.gpu.push_scopes();
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            for run in 0..more {
                self.encode_restore(repeater, &mut encoder, kernel);
                let timestamp_writes = timers.writes(Some(2 * run), Some(2 * run + 1));
                let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes };
                self.dispatch(&mut encoder.begin_compute_pass(&descriptor), kernel, place, None)?;
            }
            let bytes = timers.encode_read(&mut encoder, 2 * more);
            self.gpu.submit([encoder.finish()]);
            let times = Readback::start(&self.gpu, timers.copy.clone(), bytes);
            self.gpu.pop_scopes(scopes).await?;
            let times = times.finish(bytes, |bytes| read_times(bytes, timers.ticks)).await?;
            if !runs.add(&times) {
                return Ok(());
            }
        }
    }
}
