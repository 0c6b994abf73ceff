//! Small kernels timed on their own, without a renderer.

use std::convert::Infallible;
use std::sync::Arc;

use raystep_kernels::{Device, Gpu};
use raystep_lab::meter::{Ended, Time, Turns, in_turn};
use raystep_lab::tidy::{Row, fill};

use crate::measure::{Section, Setup};

/// Two timestamps around a submission.
pub(crate) struct Stopwatch<'a> {
    pub(crate) setup: &'a Setup,
    pub(crate) gpu: &'a Arc<Gpu>,
    set: wgpu::QuerySet,
    ticks: wgpu::Buffer,
}

impl<'a> Stopwatch<'a> {
    /// Of a GPU; `None` on a CPU.
    pub(crate) fn new(setup: &'a Setup) -> Option<Self> {
        let Device::Gpu(gpu) = &setup.meter.machine.device else { return None };
        let (label, ty, count) = (Some("stopwatch"), wgpu::QueryType::Timestamp, 2);
        let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor { label, ty, count });
        let ticks = buffer(gpu, 16, wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        Some(Self { setup, gpu, set, ticks })
    }

    /// Nanoseconds of one compute pass; `None` if a timestamp is not valid.
    pub(crate) fn time(&self, encode: impl FnOnce(&mut wgpu::ComputePass<'_>)) -> Option<u64> {
        let (gpu, machine) = (self.gpu, &self.setup.meter.machine);
        machine.wait(self.setup.meter.keep_clocks());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encode(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("stopwatch"),
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: &self.set,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            }),
        }));
        encoder.resolve_query_set(&self.set, 0..2, &self.ticks, 0);
        let read_back = buffer(gpu, 16, wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
        encoder.copy_buffer_to_buffer(&self.ticks, 0, &read_back, 0, 16);
        let bytes = machine.wait(gpu.read_after(encoder.finish(), read_back, 16)).ok()?;
        let [begin, end] = [0, 8].map(|at| bytes[at..at + 8].try_into().map_or(0, u64::from_le_bytes));
        let elapsed = end.checked_sub(begin).filter(|&ticks| begin > 0 && ticks > 0)?;
        Some((elapsed as f64 * gpu.timestamp_period_ns?) as u64)
    }

    /// A job that runs a kernel so often in one pass.
    pub(crate) fn job(&'a self, row: Row, kernel: Kernel, groups: [u32; 2], dispatches: u64) -> Job<'a> {
        (row, Box::new(move || self.time(|pass| kernel.dispatch(pass, groups, dispatches))))
    }
}

/// A buffer of so many bytes.
pub(crate) fn buffer(gpu: &Gpu, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let label = Some("measured");
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
}

/// A texture with this many layers.
pub(crate) fn texture(gpu: &Gpu, [width, height]: [u32; 2], layers: u32, format: wgpu::TextureFormat) -> wgpu::Texture {
    use wgpu::TextureUsages as U;
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: U::STORAGE_BINDING | U::TEXTURE_BINDING | U::COPY_SRC | U::COPY_DST,
        view_formats: &[],
    })
}

/// A view of all its layers.
pub(crate) fn layers(texture: &wgpu::Texture) -> wgpu::TextureView {
    let dimension = Some(wgpu::TextureViewDimension::D2Array);
    texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
}

/// A compute pipeline with the layout inferred from its source, and what is bound to it.
pub(crate) struct Kernel {
    pipeline: wgpu::ComputePipeline,
    groups: Vec<wgpu::BindGroup>,
}

impl Kernel {
    /// Binds resources by group and number.
    pub(crate) fn new(gpu: &Gpu, wgsl: &str, entry: &str, groups: &[&[(u32, wgpu::BindingResource<'_>)]]) -> Self {
        let source = wgpu::ShaderSource::Wgsl(wgsl.into());
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(entry), source });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: None,
            module: &module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        });
        let group = |(number, resources): (u32, &&[(u32, wgpu::BindingResource<'_>)])| {
            let entries = resources.iter().cloned();
            let entries: Vec<_> =
                entries.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
            let layout = pipeline.get_bind_group_layout(number);
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries })
        };
        let groups = (0..).zip(groups).map(group).collect();
        Self { pipeline, groups }
    }

    pub(crate) fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, [x, y]: [u32; 2], dispatches: u64) {
        pass.set_pipeline(&self.pipeline);
        (0..).zip(&self.groups).for_each(|(i, group)| pass.set_bind_group(i, group, &[]));
        (0..dispatches).for_each(|_| pass.dispatch_workgroups(x, y, 1));
    }
}

/// A measurement: its row, and a function that performs one repeat.
pub(crate) type Job<'a> = (Row, Box<dyn FnMut() -> Option<u64> + 'a>);

impl Section<'_> {
    /// Runs jobs interleaved, and adds their rows.
    pub(crate) fn time(&mut self, mut jobs: Vec<Job<'_>>) {
        self.setup.raise_clocks();
        let Ok(times) = in_turn(&mut jobs, Turns::of(2, self.setup.repeats()), |(_, job)| {
            Ok::<_, Infallible>(Ended::Done(Time { wall_ns: 0, device_ns: job() }))
        });
        for ((row, _), times) in jobs.into_iter().zip(times) {
            let times: Vec<Option<f64>> = times.device_ns().iter().map(|ns| ns.map(|ns| ns as f64)).collect();
            let row = row.set("clock", self.setup.meter.machine.timer().name());
            self.table.rows.push(fill::times(row, &times, 0));
        }
    }
}
