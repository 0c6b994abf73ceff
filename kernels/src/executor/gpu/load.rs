//! Arithmetic that keeps a GPU's clocks up between short measured runs.

use std::borrow::Cow;
use std::sync::Arc;

use super::Gpu;

/// A GPU with little to do lowers its clocks, within milliseconds and by a factor of up to six. Runs that are shorter
/// than that are then measured at any clock in between. A load that is submitted before each run, in order and without
/// waiting for it, keeps the GPU busy, and ends before the run's timestamps begin.
pub struct Load {
    gpu: Arc<Gpu>,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

/// About a millisecond on a large GPU: 2^18 threads of 2^14 steps each.
const WORKGROUPS: u32 = 1 << 10;

const WGSL: &str = "
@group(0) @binding(0) var<storage, read_write> result: array<f32, 256>;

@compute @workgroup_size(256)
fn load(@builtin(local_invocation_index) lane: u32) {
    var value = f32(lane);
    for (var step = 0u; step < 16384u; step++) {
        value = value * 0.999 + 0.5;
    }
    // Never true; without a write, compilers would remove the loop.
    if (value < 0.0) {
        result[lane] = value;
    }
}
";

impl Load {
    /// Compiles the load.
    #[must_use]
    pub fn new(gpu: Arc<Gpu>) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("load"),
            source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(WGSL)),
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("load"),
            layout: None,
            module: &module,
            entry_point: Some("load"),
            compilation_options: Default::default(),
            cache: None,
        });
        let result = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("load"),
            size: 4 * 256,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("load"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: result.as_entire_binding() }],
        });
        Self { gpu, pipeline, group }
    }

    /// Whether [`submit`](Self::submit) does anything: not on a software adapter, whose clocks do not matter.
    #[must_use]
    pub fn has_effect(&self) -> bool {
        matches!(self.gpu.info.device_type, wgpu::DeviceType::DiscreteGpu | wgpu::DeviceType::IntegratedGpu)
    }

    /// Submits the load, if it [has an effect](Self::has_effect).
    pub fn submit(&self) {
        if !self.has_effect() {
            return;
        }
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(WORKGROUPS, 1, 1);
        }
        self.gpu.submit([encoder.finish()]);
    }
}
