//! A compute shader that runs once, with buffers of words.

use std::sync::Arc;

use raystep_kernels::{Gpu, GpuError};
use wgpu::{Buffer, BufferUsages};

/// A compute shader on a device.
pub(super) struct Shader<'a> {
    gpu: &'a Arc<Gpu>,
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
}

/// Words as bytes.
pub(super) fn bytes_of(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

impl<'a> Shader<'a> {
    /// Compiles a source whose entry point has this name.
    pub(super) fn new(gpu: &'a Arc<Gpu>, name: &'static str, source: String) -> Self {
        let source = wgpu::ShaderSource::Wgsl(source.into());
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: Some(name),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { gpu, name, pipeline }
    }

    /// A buffer with these words, to read.
    pub(super) fn given(&self, words: &[u32]) -> Buffer {
        self.gpu.filled_buffer(self.name, &bytes_of(words), BufferUsages::STORAGE)
    }

    /// A buffer with room for so many words, to write.
    pub(super) fn room(&self, words: usize) -> Buffer {
        self.buffer(words, BufferUsages::STORAGE | BufferUsages::COPY_SRC)
    }

    fn buffer(&self, words: usize, usage: BufferUsages) -> Buffer {
        let (label, size) = (Some(self.name), 4 * words as u64);
        self.gpu.device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
    }

    /// Runs so many workgroups with these resources, bound in order. `copy` fills a buffer of so many words with what
    /// is to be read back.
    pub(super) async fn run(
        &self,
        resources: impl IntoIterator<Item = wgpu::BindingResource<'_>>,
        [x, y]: [u32; 2],
        words: usize,
        copy: impl FnOnce(&mut wgpu::CommandEncoder, &Buffer),
    ) -> Result<Vec<u32>, GpuError> {
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
        let (label, layout) = (Some(self.name), &self.pipeline.get_bind_group_layout(0));
        let group = self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries: &entries });
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
        let read_back = self.buffer(words, BufferUsages::COPY_DST | BufferUsages::MAP_READ);
        copy(&mut encoder, &read_back);
        let bytes = self.gpu.read_after(encoder.finish(), read_back, 4 * words as u64).await?;
        Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}
