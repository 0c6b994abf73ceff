//! Pipelines and bind groups, made from what reflection says of each variant: the host binds by name.

use std::borrow::Cow;

use super::books::{Books, Place, is_dynamic};
use super::compiled::Compiled;
use super::{Gpu, GpuError};
use crate::plan::Plan;
use crate::programs::closest_hit::kernels::Kernel;
use crate::scene_data::SceneData;
use crate::shader::{Binding, Resource, Variant};
use crate::tables::stream::Stream;

pub(super) struct KernelPipeline {
    kernel: Kernel,
    /// Names of program and kernel.
    pub(super) label: String,
    pub(super) pipeline: wgpu::ComputePipeline,
    /// The streams that it changes.
    pub(super) writes: Vec<Stream>,
    /// Groups 0 and 1: streams, and scene data.
    pub(super) groups: Vec<wgpu::BindGroup>,
    /// Group 2: the books, one for each combination of even and odd slots; empty where it binds none.
    live: Vec<wgpu::BindGroup>,
    /// Names in group 2 that have dynamic offsets, in order.
    offsets: Vec<String>,
}

pub(super) struct Pipelines(Vec<KernelPipeline>);

impl Pipelines {
    pub(super) fn new(
        gpu: &Gpu,
        plan: &Plan,
        streams: &[(Stream, wgpu::Texture)],
        buffers: &[(&'static str, wgpu::Buffer)],
        books: &Books,
        data: &SceneData,
    ) -> Result<Self, GpuError> {
        let pipeline = |v| {
            let compiled = gpu.compiled.get(&gpu.device, v, is_proved(plan, v, data));
            KernelPipeline::new(&gpu.device, v, compiled, streams, buffers, books)
        };
        plan.variants.iter().map(pipeline).collect::<Result<_, _>>().map(Self)
    }

    pub(super) fn get(&self, kernel: Kernel) -> Option<&KernelPipeline> {
        self.0.iter().find(|p| p.kernel == kernel)
    }
}

/// The group of the books.
const LIVE_GROUP: u32 = 2;

impl KernelPipeline {
    fn new(
        device: &wgpu::Device,
        variant: &Variant,
        compiled: Compiled,
        streams: &[(Stream, wgpu::Texture)],
        buffers: &[(&'static str, wgpu::Buffer)],
        books: &Books,
    ) -> Result<Self, GpuError> {
        let (name, label) = (variant.kernel.name(), variant.label());
        let (mut groups, mut live, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
        for (group, layout) in (0..).zip(&compiled.layouts) {
            let bindings: Vec<_> = variant.bindings.iter().filter(|b| b.group == group).collect();
            let make = |resources: Vec<wgpu::BindingResource<'_>>| {
                let entries: Vec<_> = bindings
                    .iter()
                    .zip(resources)
                    .map(|(b, resource)| wgpu::BindGroupEntry { binding: b.index, resource })
                    .collect();
                let descriptor = wgpu::BindGroupDescriptor { label: Some(&label), layout, entries: &entries };
                device.create_bind_group(&descriptor)
            };
            if group == LIVE_GROUP {
                let names = bindings.iter().map(|b| &b.name).filter(|name| is_dynamic(name));
                offsets = names.cloned().collect::<Vec<_>>();
                for slots in 0..4 {
                    let resources: Option<Vec<_>> =
                        bindings.iter().map(|b| books.binding(variant.kernel, &b.name, slots)).collect();
                    live.push(make(resources.ok_or(GpuError::Missing(name))?));
                }
            } else {
                let views = bindings.iter().map(|b| view(b, streams)).collect::<Vec<_>>();
                let mut resources = Vec::new();
                for (binding, view) in bindings.iter().zip(&views) {
                    resources.push(match view {
                        Some(view) => wgpu::BindingResource::TextureView(view),
                        None => buffers
                            .iter()
                            .find(|(n, _)| *n == binding.name)
                            .map(|(_, b)| b.as_entire_binding())
                            .ok_or(GpuError::Missing(name))?,
                    });
                }
                groups.push(make(resources));
            }
        }
        let writes = variant.written_streams().collect();
        Ok(Self { kernel: variant.kernel, label, pipeline: compiled.pipeline, writes, groups, live, offsets })
    }

    /// Binds the books for a pass.
    pub(super) fn set_live(&self, pass: &mut wgpu::ComputePass<'_>, place: &Place) {
        if let Some(group) = self.live.get(place.group()) {
            let offsets: Vec<u32> = self.offsets.iter().filter_map(|name| place.offset(name)).collect();
            pass.set_bind_group(LIVE_GROUP, group, &offsets);
        }
    }
}

/// Whether no index of this kernel needs a check: it is the fused kernel as this crate composes it for the plan's
/// options, be it that somebody has changed the plan, and what it indexes holds for just these options. Where a walk
/// resumes, it indexes by what its streams hold, which anybody may have written: that is not proved.
fn is_proved(plan: &Plan, variant: &Variant, data: &SceneData) -> bool {
    variant.kernel == Kernel::Fused
        && !plan.features.resumes
        && data.indices_hold(&plan.features)
        && Variant::new(Kernel::Fused, &plan.features)
            .is_ok_and(|own| own.source == variant.source && own.bindings == variant.bindings)
}

fn view(binding: &Binding, streams: &[(Stream, wgpu::Texture)]) -> Option<wgpu::TextureView> {
    let (Resource::ReadStream(stream) | Resource::WriteStream { stream, .. }) = binding.resource else { return None };
    let (_, texture) = streams.iter().find(|(s, _)| *s == stream)?;
    Some(texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    }))
}

/// Counts the rays in each state after the fused kernel, which keeps no books: a global atomic for each
/// of its small workgroups would cost it more than its shortest runs take.
pub(super) struct Counting {
    pub(super) label: String,
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) group: wgpu::BindGroup,
}

impl Counting {
    pub(super) fn new(device: &wgpu::Device, plan: &Plan, state: &wgpu::Texture, books: &Books) -> Self {
        let name = plan.label("count");
        let label = Some(name.as_str());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label,
            source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(include_str!("../../shared/count.wgsl"))),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: Some("count"),
            compilation_options: Default::default(),
            cache: None,
        });
        let view = state.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let sent = wgpu::BufferBinding { buffer: &books.sent, offset: 0, size: std::num::NonZeroU64::new(32) };
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Buffer(sent) },
            ],
        });
        Self { label: name, pipeline, group }
    }
}

#[cfg(test)]
mod tests {
    use raystep_scenes::{Camera, generate};

    use super::*;
    use crate::options::{Accelerator, Options, RaySource, ScheduleKind};
    use crate::plan::Limits;

    /// What is compiled without checks is the very shader that the proof is about, over the very data.
    #[test]
    fn only_our_own_shader_of_these_options_over_data_that_holds_is_proved() {
        let scene = generate::soup(300, 1).expect("soup");
        let plan = |accelerator, schedule| {
            let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 8, height: 8 };
            let options = Options { accelerator, schedule, ..Options::new(rays) };
            Plan::new(&scene, &options, &Limits::CPU).expect("a plan")
        };
        let (of_grid, _) = plan(Accelerator::Grid, ScheduleKind::Fused);
        for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
            let (plan, data) = plan(accelerator, ScheduleKind::Fused);
            for variant in &plan.variants {
                assert_eq!(is_proved(&plan, variant, &data), variant.kernel == Kernel::Fused, "{accelerator}");
            }
            let fused = plan.variant(Kernel::Fused).expect("fused");
            let mut changed = fused.clone();
            changed.source += "// not ours\n";
            assert!(!is_proved(&plan, &changed, &data), "{accelerator}: another text");
            let mut changed = fused.clone();
            changed.bindings.reverse();
            assert!(!is_proved(&plan, &changed, &data), "{accelerator}: other bindings");
            let mut resumes = plan.clone();
            resumes.features.resumes = true;
            let variant = Variant::new(Kernel::Fused, &resumes.features).expect("a variant");
            assert!(!is_proved(&resumes, &variant, &data), "{accelerator}: places that streams hold");
            let mut broken = data.clone();
            broken.packed_triangles.clear();
            assert!(!is_proved(&plan, fused, &broken), "{accelerator}: data that does not hold");
            if accelerator != Accelerator::Grid {
                let other = of_grid.variant(Kernel::Fused).expect("fused");
                assert!(!is_proved(&plan, other, &data), "{accelerator}: a shader of other options");
            }
        }
        let (plan, data) = plan(Accelerator::Grid, ScheduleKind::Second);
        assert!(plan.variants.iter().all(|variant| !is_proved(&plan, variant, &data)));
    }
}
