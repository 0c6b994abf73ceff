//! Pipelines and bind groups, made from what reflection says of each variant: the host binds by name.

use std::borrow::Cow;

use super::{GpuError, stream_format};
use crate::kernel::Kernel;
use crate::plan::{COUNT_SLOT_BYTES, COUNT_SLOTS};
use crate::shader::{Binding, Resource, Variant};
use crate::stream::{Stream, Texel};

pub(super) struct KernelPipeline {
    kernel: Kernel,
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) groups: Vec<wgpu::BindGroup>,
}

pub(super) struct Pipelines(Vec<KernelPipeline>);

impl Pipelines {
    pub(super) fn new(
        device: &wgpu::Device,
        variants: &[Variant],
        streams: &[(Stream, wgpu::Texture)],
        buffers: &[(&'static str, wgpu::Buffer)],
    ) -> Result<Self, GpuError> {
        variants.iter().map(|v| KernelPipeline::new(device, v, streams, buffers)).collect::<Result<_, _>>().map(Self)
    }

    pub(super) fn get(&self, kernel: Kernel) -> Option<&KernelPipeline> {
        self.0.iter().find(|p| p.kernel == kernel)
    }
}

impl KernelPipeline {
    fn new(
        device: &wgpu::Device,
        variant: &Variant,
        streams: &[(Stream, wgpu::Texture)],
        buffers: &[(&'static str, wgpu::Buffer)],
    ) -> Result<Self, GpuError> {
        let name = variant.kernel.name();
        let group_count = variant.bindings.iter().map(|b| b.group + 1).max().unwrap_or(0);
        let (mut layouts, mut groups) = (Vec::new(), Vec::new());
        for group in 0..group_count {
            let bindings: Vec<_> = variant.bindings.iter().filter(|b| b.group == group).collect();
            let entries: Vec<_> = bindings.iter().map(|b| layout_entry(b)).collect();
            let layout = device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries });
            let views = bindings.iter().map(|b| view(b, streams)).collect::<Vec<_>>();
            let mut entries = Vec::new();
            for (binding, view) in bindings.iter().zip(&views) {
                let resource = match view {
                    Some(view) => wgpu::BindingResource::TextureView(view),
                    None => buffers
                        .iter()
                        .find(|(n, _)| *n == binding.name)
                        .map(|(_, b)| b.as_entire_binding())
                        .ok_or(GpuError::Missing(name))?,
                };
                entries.push(wgpu::BindGroupEntry { binding: binding.index, resource });
            }
            groups.push(device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(name),
                layout: &layout,
                entries: &entries,
            }));
            layouts.push(layout);
        }
        let layouts: Vec<_> = layouts.iter().map(Some).collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(&variant.source)),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(name),
            compilation_options: Default::default(),
            cache: None,
        });
        Ok(Self { kernel: variant.kernel, pipeline, groups })
    }
}

fn view(binding: &Binding, streams: &[(Stream, wgpu::Texture)]) -> Option<wgpu::TextureView> {
    let (Resource::ReadStream(stream) | Resource::WriteStream { stream, .. }) = binding.resource else { return None };
    let (_, texture) = streams.iter().find(|(s, _)| *s == stream)?;
    Some(texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    }))
}

fn layout_entry(binding: &Binding) -> wgpu::BindGroupLayoutEntry {
    let ty = match binding.resource {
        Resource::ReadStream(stream) => wgpu::BindingType::Texture {
            sample_type: match stream.info().texel {
                Texel::F32 => wgpu::TextureSampleType::Float { filterable: false },
                Texel::U32 => wgpu::TextureSampleType::Uint,
            },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        },
        Resource::WriteStream { stream, readable } => wgpu::BindingType::StorageTexture {
            access: if readable {
                wgpu::StorageTextureAccess::ReadWrite
            } else {
                wgpu::StorageTextureAccess::WriteOnly
            },
            format: stream_format(stream),
            view_dimension: wgpu::TextureViewDimension::D2Array,
        },
        Resource::Uniform => buffer_type(wgpu::BufferBindingType::Uniform, false),
        Resource::Storage => buffer_type(wgpu::BufferBindingType::Storage { read_only: true }, false),
    };
    wgpu::BindGroupLayoutEntry { binding: binding.index, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}

fn buffer_type(ty: wgpu::BufferBindingType, has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None }
}

/// Counts the rays in each state after every pass, into one slot a pass.
pub(super) struct Counting {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) group: wgpu::BindGroup,
    pub(super) slots: wgpu::Buffer,
    pub(super) copy: wgpu::Buffer,
}

impl Counting {
    pub(super) fn new(device: &wgpu::Device, state: &wgpu::Texture) -> Self {
        use wgpu::BufferUsages as U;
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: COUNT_SLOTS * COUNT_SLOT_BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        let slots = buffer("live_counts", U::STORAGE | U::COPY_SRC | U::COPY_DST);
        let copy = buffer("live_counts_copy", U::COPY_DST | U::MAP_READ);
        let compute = wgpu::ShaderStages::COMPUTE;
        let state_type = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let counts_type = buffer_type(wgpu::BufferBindingType::Storage { read_only: false }, true);
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: compute, ty, count: None };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("count"),
            entries: &[entry(0, state_type), entry(1, counts_type)],
        });
        let view = state.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let slot = wgpu::BufferBinding { buffer: &slots, offset: 0, size: std::num::NonZeroU64::new(32) };
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("count"),
            layout: &layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Buffer(slot) },
            ],
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("count"),
            source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(include_str!("../../shared/count.wgsl"))),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("count"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("count"),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("count"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { pipeline, group, slots, copy }
    }
}
