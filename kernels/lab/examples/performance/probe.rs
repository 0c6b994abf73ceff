//! Small kernels timed on their own, without a renderer.

use std::borrow::Cow;
use std::convert::Infallible;

use raystep_kernels::Gpu;
use raystep_lab::meter::{self, Ended, Time, Turns};

use crate::machine::Machine;
use crate::row::Probe;

/// Two timestamps around a submission.
pub(crate) struct Stopwatch<'a> {
    machine: &'a Machine,
    gpu: &'a Gpu,
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    copy: wgpu::Buffer,
}

impl<'a> Stopwatch<'a> {
    pub(crate) fn new(machine: &'a Machine, gpu: &'a Gpu) -> Self {
        use wgpu::BufferUsages as U;
        let buffer = |usage| {
            let (label, size, mapped_at_creation) = (Some("stopwatch"), 16, false);
            gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        Self {
            machine,
            gpu,
            set: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stopwatch"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(U::QUERY_RESOLVE | U::COPY_SRC),
            copy: buffer(U::COPY_DST | U::MAP_READ),
        }
    }

    /// Nanoseconds of one compute pass; `None` if a timestamp is not valid.
    pub(crate) fn time(&self, encode: impl FnOnce(&mut wgpu::ComputePass<'_>)) -> Option<u64> {
        self.machine.keep_clocks();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encode(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("stopwatch"),
            timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                query_set: &self.set,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            }),
        }));
        encoder.resolve_query_set(&self.set, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copy, 0, 16);
        self.gpu.submit([encoder.finish()]);
        self.copy.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        self.machine.settle();
        let mut ticks = [0u64; 2];
        bytemuck::bytes_of_mut(&mut ticks).copy_from_slice(&self.copy.slice(..).get_mapped_range().ok()?);
        self.copy.unmap();
        let [begin, end] = ticks;
        let elapsed = end.checked_sub(begin).filter(|&ticks| begin > 0 && ticks > 0)?;
        Some((elapsed as f64 * self.gpu.timestamp_period_ns?) as u64)
    }
}

/// A compute pipeline with the layout inferred from its source.
pub(crate) fn pipeline(gpu: &Gpu, wgsl: &str, entry: &str) -> wgpu::ComputePipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(wgsl)),
    });
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: None,
        module: &module,
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    })
}

/// Binds resources by number.
pub(crate) fn bind(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    group: u32,
    resources: &[(u32, wgpu::BindingResource<'_>)],
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.clone() })
        .collect();
    let layout = pipeline.get_bind_group_layout(group);
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries })
}

/// A texture with this many layers.
pub(crate) fn texture(
    gpu: &Gpu,
    (width, height): (u32, u32),
    layers: u32,
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
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

/// A measurement: its row, and a function that performs one repeat.
pub(crate) type Job<'a> = (Probe, Box<dyn FnMut() -> Option<u64> + 'a>);

/// Runs jobs interleaved.
pub(crate) fn in_turn(machine: &Machine, mut jobs: Vec<Job<'_>>) -> Vec<Probe> {
    machine.raise_clocks();
    let times = meter::in_turn(&mut jobs, Turns::of(2, machine.repeats()), |(_, job)| {
        Ok::<_, Infallible>(Ended::Done(Time { wall_ns: 0, device_ns: job() }))
    });
    let Ok(times) = times;
    jobs.into_iter().zip(times).map(|((probe, _), times)| probe.with_times(&times.device_ns())).collect()
}
