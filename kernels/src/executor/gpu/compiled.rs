//! Pipelines of a device, each compiled once: runs that differ in scene, size or camera share them.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use super::pipelines::{layout_entry, shader_module};
use crate::shader::{Binding, Variant};

/// What does not depend on a run's textures and buffers.
#[derive(Clone)]
pub(super) struct Compiled {
    pub(super) pipeline: wgpu::ComputePipeline,
    /// One for each group.
    pub(super) layouts: Vec<wgpu::BindGroupLayout>,
}

/// Whether two variants are one pipeline.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    source: String,
    bindings: Vec<Binding>,
    is_proved: bool,
}

/// All pipelines that were compiled on a device.
#[derive(Default)]
pub(super) struct Pipelines(Mutex<HashMap<Key, Compiled>>);

/// Most that are kept: a program has some ten kernels, each in a few variants.
const MOST: usize = 256;

impl Pipelines {
    /// The pipeline of a variant; without bounds checks where that is proved.
    pub(super) fn get(&self, device: &wgpu::Device, variant: &Variant, is_proved: bool) -> Compiled {
        let key = Key { source: variant.source.clone(), bindings: variant.bindings.clone(), is_proved };
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(compiled) = kept.get(&key) {
            return compiled.clone();
        }
        let compiled = compile(device, variant, is_proved);
        if kept.len() >= MOST {
            kept.clear();
        }
        kept.insert(key, compiled.clone());
        compiled
    }

    /// Forgets all: one of them may be what the device refused.
    pub(super) fn clear(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

fn compile(device: &wgpu::Device, variant: &Variant, is_proved: bool) -> Compiled {
    let name = variant.kernel.name();
    let groups = variant.bindings.iter().map(|b| b.group + 1).max().unwrap_or(0);
    let layouts: Vec<_> = (0..groups)
        .map(|group| {
            let entries: Vec<_> = variant.bindings.iter().filter(|b| b.group == group).map(layout_entry).collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries })
        })
        .collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &layouts.iter().map(Some).collect::<Vec<_>>(),
        immediate_size: 0,
    });
    let module = shader_module(device, variant, is_proved);
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(name),
        compilation_options: wgpu::PipelineCompilationOptions {
            zero_initialize_workgroup_memory: variant.kernel != crate::kernel::Kernel::Fused,
            ..Default::default()
        },
        cache: None,
    });
    Compiled { pipeline, layouts }
}
