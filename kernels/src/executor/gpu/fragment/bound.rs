//! Bind groups: which textures of the streams a shader reads depends on the pass.

use std::collections::HashMap;

use super::streams::StreamTextures;
use crate::executor::gpu::GpuError;
use crate::executor::gpu::uploaded::AllUploaded;
use crate::fragment::Shader;
use crate::shader::{Binding, Resource};
use crate::tables::sizes::COUNT_SLOT_BYTES;
use crate::tables::stream::Stream;

/// What a shader binds.
pub(super) struct Bound {
    bindings: Vec<Binding>,
    layouts: Vec<wgpu::BindGroupLayout>,
    /// Bind groups, by which textures of the streams they hold: a bit for each binding of a stream.
    groups: HashMap<u64, Vec<Group>>,
}

/// A bind group.
pub(super) struct Group {
    group: wgpu::BindGroup,
    /// Whether it holds counters, of which each pass has its own.
    is_live: bool,
}

/// What shaders bind.
pub(super) struct Bindable<'a> {
    pub(super) device: &'a wgpu::Device,
    pub(super) streams: &'a StreamTextures,
    pub(super) buffers: &'a AllUploaded,
    pub(super) sent: Option<&'a wgpu::Buffer>,
    /// Number of states that it counts.
    pub(super) states: u64,
    /// The pass's slot in `sent`.
    pub(super) slot: u32,
    /// The streams that are read from their other texture, where the copy is.
    pub(super) copied: &'a [Stream],
}

/// Sets the groups for a pass with this slot.
pub(super) fn bind(groups: &[Group], slot: u32, mut set: impl FnMut(u32, &wgpu::BindGroup, &[u32])) {
    let offset = [slot * COUNT_SLOT_BYTES as u32];
    for (index, group) in (0..).zip(groups) {
        set(index, &group.group, if group.is_live { &offset } else { &[] });
    }
}

impl Bound {
    pub(super) fn new(device: &wgpu::Device, shader: &Shader, visibility: wgpu::ShaderStages) -> Self {
        let count = shader.bindings.iter().map(|b| b.group + 1).max().unwrap_or(0);
        let layout = |group: u32| {
            let entries = shader.bindings.iter().filter(|b| b.group == group).map(|b| wgpu::BindGroupLayoutEntry {
                binding: b.index,
                visibility,
                ty: binding_type(&b.resource),
                count: None,
            });
            let entries: Vec<_> = entries.collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
        };
        let layouts = (0..count).map(layout).collect();
        Self { bindings: shader.bindings.clone(), layouts, groups: HashMap::new() }
    }

    pub(super) fn layout(&self, device: &wgpu::Device, label: &str) -> wgpu::PipelineLayout {
        device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &self.layouts.iter().map(Some).collect::<Vec<_>>(),
            immediate_size: 0,
        })
    }

    /// Whether a group holds counters.
    fn is_live(&self, group: u32) -> bool {
        self.bindings.iter().any(|b| b.group == group && matches!(b.resource, Resource::Live { .. }))
    }

    /// The bind groups, with the textures that hold the streams' values now.
    pub(super) fn groups(&mut self, with: &Bindable<'_>, name: &'static str) -> Result<&[Group], GpuError> {
        let missing = || GpuError::Missing(name);
        let mut held = Vec::new();
        for binding in &self.bindings {
            held.push(match binding.stream() {
                None => None,
                Some(stream) => {
                    let textures = with.streams.get(stream).ok_or_else(missing)?;
                    let is_copied = with.copied.contains(&stream);
                    Some((textures, if is_copied { textures.other_index() } else { textures.holder }))
                }
            });
        }
        let key = held.iter().flatten().enumerate().fold(0, |key, (bit, (_, index))| key | (*index as u64) << bit);
        if !self.groups.contains_key(&key) {
            let mut made = Vec::new();
            for (group, layout) in (0..).zip(&self.layouts) {
                let mut entries = Vec::new();
                for (binding, held) in self.bindings.iter().zip(&held).filter(|(binding, _)| binding.group == group) {
                    let resource = match (held, &binding.resource) {
                        (Some((textures, index)), _) => wgpu::BindingResource::TextureView(textures.view(*index)),
                        (None, Resource::Live { .. }) => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                            buffer: with.sent.ok_or_else(missing)?,
                            offset: 0,
                            size: std::num::NonZeroU64::new(4 * with.states),
                        }),
                        (None, _) => {
                            let found = with.buffers.iter().find(|(name, _)| *name == binding.name);
                            found.map(|(_, uploaded)| uploaded.binding()).ok_or_else(missing)?
                        }
                    };
                    entries.push(wgpu::BindGroupEntry { binding: binding.index, resource });
                }
                let descriptor = wgpu::BindGroupDescriptor { label: Some(name), layout, entries: &entries };
                made.push(Group { group: with.device.create_bind_group(&descriptor), is_live: self.is_live(group) });
            }
            self.groups.insert(key, made);
        }
        self.groups.get(&key).map(Vec::as_slice).ok_or_else(missing)
    }
}

fn binding_type(resource: &Resource) -> wgpu::BindingType {
    let buffer = |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    match resource {
        Resource::ReadStream(_) | Resource::WriteStream { .. } | Resource::WriteStreams { .. } | Resource::List => {
            wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            }
        }
        Resource::Uniform | Resource::Launch => buffer(wgpu::BufferBindingType::Uniform, false),
        Resource::Storage => buffer(wgpu::BufferBindingType::Storage { read_only: true }, false),
        Resource::Live { writable } => buffer(wgpu::BufferBindingType::Storage { read_only: !writable }, true),
    }
}
