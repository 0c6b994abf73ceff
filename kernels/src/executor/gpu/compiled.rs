//! Caches a device's pipelines, each compiled once: runs that differ only in scene, size or camera share them.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use super::books::is_dynamic;
use super::stream_format;
use crate::options::scene_data::SceneDataKind;
use crate::plan::{Plan, Sharing};
use crate::shader::{Binding, Resource, ShaderError, Variant};
use crate::tables::kernel::Role;
use crate::tables::stream::Texel;

/// A pipeline and its layouts: the part that does not depend on a run's textures and buffers.
#[derive(Clone)]
pub(super) struct Compiled {
    pub(super) pipeline: wgpu::ComputePipeline,
    /// One per bind group.
    pub(super) layouts: Vec<wgpu::BindGroupLayout>,
    /// What it binds.
    pub(super) bindings: Vec<Binding>,
}

/// Identifies a pipeline: variants with equal keys share it.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    source: String,
    bindings: Vec<Binding>,
    is_proved: bool,
    scene_data: SceneDataKind,
    sharing: Sharing,
}

/// All pipelines compiled on a device.
#[derive(Default)]
pub(super) struct Pipelines(Mutex<HashMap<Key, Compiled>>);

/// Most pipelines to keep: a program has about ten kernels, each in a few variants.
const MOST: usize = 256;

impl Pipelines {
    /// The pipeline of a variant, compiled without bounds checks if that is proved safe.
    ///
    /// # Errors
    /// If its lists cannot be in textures, or its streams cannot share any, which is a bug.
    pub(super) fn get(
        &self,
        device: &wgpu::Device,
        variant: &Variant,
        is_proved: bool,
        plan: &Plan,
    ) -> Result<Compiled, ShaderError> {
        let (scene_data, sharing) = (plan.features.scene_data, &plan.sharing);
        let (source, bindings) = (variant.source.clone(), variant.bindings.clone());
        let key = Key { source, bindings, is_proved, scene_data, sharing: sharing.clone() };
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(compiled) = kept().get(&key) {
            return Ok(compiled.clone());
        }
        let guarded = variant.guarded(plan.turns)?;
        let variant = guarded.as_ref().unwrap_or(variant);
        let shared = variant.sharing(&sharing.groups, sharing.most)?;
        // What was rewritten is not the shader of the proof.
        let is_proved = is_proved && guarded.is_none() && shared.is_none();
        let variant = shared.as_ref().unwrap_or(variant);
        let compiled = match scene_data {
            SceneDataKind::Buffers => compile(device, variant, is_proved),
            SceneDataKind::Textures => compile(device, &variant.in_textures()?, is_proved),
        };
        let mut kept = kept();
        if kept.len() >= MOST {
            kept.clear();
        }
        kept.insert(key, compiled.clone());
        Ok(compiled)
    }

    /// Drops all pipelines: one of them may be what the device refused.
    pub(super) fn clear(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

fn compile(device: &wgpu::Device, variant: &Variant, is_proved: bool) -> Compiled {
    let label = variant.label();
    let groups = variant.bindings.iter().map(|b| b.group + 1).max().unwrap_or(0);
    let layouts: Vec<_> = (0..groups)
        .map(|group| {
            let entries: Vec<_> = variant.bindings.iter().filter(|b| b.group == group).map(layout_entry).collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&label), entries: &entries })
        })
        .collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&label),
        bind_group_layouts: &layouts.iter().map(Some).collect::<Vec<_>>(),
        immediate_size: 0,
    });
    let module = shader_module(device, variant, is_proved);
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(&label),
        layout: Some(&layout),
        module: &module,
        // The only one. Where a shader was rewritten, it may have another name than the kernel.
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions {
            zero_initialize_workgroup_memory: variant.kernel.role() != Role::Whole,
            ..Default::default()
        },
        cache: None,
    });
    Compiled { pipeline, layouts, bindings: variant.bindings.clone() }
}

/// Compiles a kernel, without bounds checks if `is_proved` says that no index needs one; see the pipelines of a plan.
fn shader_module(device: &wgpu::Device, variant: &Variant, is_proved: bool) -> wgpu::ShaderModule {
    let label = variant.label();
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(&label),
        source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(&variant.source)),
    };
    if !is_proved {
        return device.create_shader_module(descriptor);
    }
    // SAFETY: an unchecked shader must neither index out of bounds nor run without end.
    //
    // - Which shader it is: `is_proved` composes fused.wgsl again from the options that the proof is about, and
    //   compares text and bindings with those compiled here.
    // - What it reads: the buffers are made from the very `SceneData` of the proof, whole, and bound under the names in
    //   the shader. Nobody else has access to them, and the executor later writes only `first_row` and `size` of `scene`,
    //   the size of its own streams. Where they are textures, `Variant::in_textures` replaced nothing but loads, and the
    //   texel `get_address(i, k)` of each of a list's n words is in the texture of k by k texels, as k * k >= n.
    // - No index comes from a stream: walks that resume are not proved.
    // - Indices that come from buffers, by `SceneData::indices_hold`: offsets and items of the grid, entries of leaves,
    //   children of nodes, and triangles. Distances and cells are looked up by cell.
    // - Cells, by the shader: `enter_grid` clamps to the grid, or its `inside` is false; so is that of `advance` and
    //   `leap` outside of the grid, or outside of the arrays with the paper's rules. NaN takes the same branches.
    // - Virtual cells of an irregular grid, by the shader: `enter_grid` clamps them, and `step_voxel` ends the walk outside
    //   of the grid. The cells that they lead to, by `SceneData::indices_hold`: the loop over the map's levels ends at one.
    // - The stack, by `SceneData::indices_hold`: at most one group of siblings waits per level, and none at the root's.
    // - Texels, by the shader: threads outside of `scene.size` return at once, and every stream of the image has this size;
    //   `launch` has that of the streams of other elements.
    // - Loops, by the proof: lists are finite, and the nodes form one tree, each visited at most once. By the shader:
    //   every step of a walk advances along one axis until it leaves the grid, or its iterations are bounded.
    #[allow(unsafe_code)]
    unsafe {
        device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked())
    }
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
        Resource::WriteStreams { first } => wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::ReadWrite,
            format: stream_format(first),
            view_dimension: wgpu::TextureViewDimension::D2Array,
        },
        Resource::List => wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        Resource::Uniform => buffer_type(wgpu::BufferBindingType::Uniform, false),
        Resource::Launch => buffer_type(wgpu::BufferBindingType::Uniform, true),
        Resource::Storage => buffer_type(wgpu::BufferBindingType::Storage { read_only: true }, false),
        Resource::Live { writable } => {
            buffer_type(wgpu::BufferBindingType::Storage { read_only: !writable }, is_dynamic(binding))
        }
    };
    wgpu::BindGroupLayoutEntry { binding: binding.index, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}

fn buffer_type(ty: wgpu::BufferBindingType, has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None }
}
