//! Pipelines and bind groups, made from the reflection of each variant: the host binds by name.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::books::{Books, Place, is_dynamic};
use super::compiled::Compiled;
use super::uploaded::AllUploaded;
use super::{Gpu, GpuError, StreamTexture};
use crate::plan::Plan;
use crate::program::{Kernel, live};
use crate::scene_data::SceneData;
use crate::shader::{Binding, Resource, Variant};
use crate::tables::stream::Stream;

pub(super) struct KernelPipeline {
    kernel: Kernel,
    /// Names of the program and the kernel.
    pub(super) label: String,
    compiled: Compiled,
    bindings: Vec<Binding>,
    /// The streams that it writes.
    pub(super) writes: Vec<Stream>,
    /// The lists whose slots it binds: a bit for each.
    lists: u64,
    /// Its bind groups; `None` until each of its streams has a size.
    bound: Option<Bound>,
}

struct Bound {
    /// Groups 0 and 1: streams and scene data.
    groups: Vec<wgpu::BindGroup>,
    /// Group 2: counters and lists, a group for each combination of even and odd slots that a pass has needed.
    live: HashMap<u64, wgpu::BindGroup>,
    /// Names in group 2 with dynamic offsets, in order.
    offsets: Vec<String>,
}

/// Everything that pipelines can bind.
pub(super) struct Bindable<'a> {
    pub(super) device: &'a wgpu::Device,
    pub(super) streams: &'a [(Stream, StreamTexture)],
    pub(super) buffers: &'a AllUploaded,
}

pub(super) struct Pipelines(Vec<KernelPipeline>);

impl Pipelines {
    pub(super) fn new(gpu: &Gpu, plan: &Plan, data: &SceneData, bindable: &Bindable<'_>) -> Result<Self, GpuError> {
        let pipeline = |variant: &Variant| {
            let writes = variant.written_streams().collect();
            let is_proved = is_proved(plan, variant, data);
            let compiled = gpu.compiled.get(&gpu.device, variant, is_proved, plan);
            let compiled = compiled.map_err(|error| GpuError::Refused(error.to_string()))?;
            // Lists in textures are bound by the names of the buffers.
            let (kernel, label, bindings) = (variant.kernel, variant.label(), compiled.bindings.clone());
            Ok(KernelPipeline {
                kernel,
                label,
                compiled,
                lists: lists_of(kernel, &bindings),
                bindings,
                writes,
                bound: None,
            })
        };
        let mut pipelines = Self(plan.variants.iter().map(pipeline).collect::<Result<_, GpuError>>()?);
        pipelines.bind(bindable, |_| true)?;
        Ok(pipelines)
    }

    /// Binds the resources that each pipeline names, if one of its streams is `new`; skips pipelines with a stream that
    /// has no size yet.
    pub(super) fn bind(&mut self, bindable: &Bindable<'_>, new: impl Fn(Stream) -> bool) -> Result<(), GpuError> {
        for pipeline in &mut self.0 {
            let streams: Vec<Stream> = pipeline.bindings.iter().filter_map(Binding::texture_of).collect();
            let has = |stream: &Stream| bindable.streams.iter().any(|(s, _)| s == stream);
            if !streams.iter().all(has) {
                pipeline.bound = None;
            } else if streams.iter().any(|&stream| new(stream)) {
                pipeline.bound = Some(Bound::new(pipeline, bindable)?);
            }
        }
        Ok(())
    }

    /// Makes what passes of this kernel bind, if it is not there yet.
    pub(super) fn prepare(
        &mut self,
        kernel: Kernel,
        place: &Place,
        device: &wgpu::Device,
        books: &Books,
    ) -> Result<(), GpuError> {
        self.0.iter_mut().filter(|p| p.kernel == kernel).try_for_each(|p| p.prepare(place, device, books))
    }

    pub(super) fn get(&self, kernel: Kernel) -> Option<&KernelPipeline> {
        self.0.iter().find(|p| p.kernel == kernel)
    }
}

/// The lists whose slots a kernel binds: a bit for each.
fn lists_of(kernel: Kernel, bindings: &[Binding]) -> u64 {
    let lists = kernel.program().lists.iter().enumerate();
    let is_bound = |list: usize, name: &str| kernel.list() == Some(list) || bindings.iter().any(|b| b.name == name);
    lists.filter(|(list, info)| is_bound(*list, info.name)).fold(0, |bits, (list, _)| bits | 1 << list)
}

/// The bind group of counters, lists and launch parameters.
const LIVE_GROUP: u32 = 2;

impl Bound {
    fn new(of: &KernelPipeline, with: &Bindable<'_>) -> Result<Self, GpuError> {
        let (kernel, label) = (of.kernel, Some(of.label.as_str()));
        let missing = || GpuError::Missing(kernel.name());
        let (mut groups, mut offsets) = (Vec::new(), Vec::new());
        for (group, layout) in (0..).zip(&of.compiled.layouts) {
            let bindings: Vec<_> = of.bindings.iter().filter(|b| b.group == group).collect();
            if group == LIVE_GROUP {
                offsets = bindings.iter().filter(|b| is_dynamic(b)).map(|b| b.name.clone()).collect();
            } else {
                let views = bindings.iter().map(|b| view(b, with.streams)).collect::<Vec<_>>();
                let mut resources = Vec::new();
                for (binding, view) in bindings.iter().zip(&views) {
                    let buffer = || with.buffers.iter().find(|(n, _)| *n == binding.name);
                    resources.push(match view {
                        Some(view) => wgpu::BindingResource::TextureView(view),
                        None => buffer().map(|(_, b)| b.binding()).ok_or_else(missing)?,
                    });
                }
                groups.push(bind_group(with.device, label, layout, &bindings, resources));
            }
        }
        Ok(Self { groups, live: HashMap::new(), offsets })
    }
}

fn bind_group(
    device: &wgpu::Device,
    label: Option<&str>,
    layout: &wgpu::BindGroupLayout,
    bindings: &[&Binding],
    resources: Vec<wgpu::BindingResource<'_>>,
) -> wgpu::BindGroup {
    let entry = |(b, resource): (&&Binding, _)| wgpu::BindGroupEntry { binding: b.index, resource };
    let entries: Vec<_> = bindings.iter().zip(resources).map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries: &entries })
}

impl KernelPipeline {
    /// Makes the bind group of counters and lists for a pass, if it is the first with these slots.
    fn prepare(&mut self, place: &Place, device: &wgpu::Device, books: &Books) -> Result<(), GpuError> {
        let (parities, kernel) = (place.parities() & self.lists, self.kernel);
        let Some(bound) = &mut self.bound else { return Ok(()) };
        let Some(layout) = self.compiled.layouts.get(LIVE_GROUP as usize) else { return Ok(()) };
        if let Entry::Vacant(place) = bound.live.entry(parities) {
            let bindings: Vec<&Binding> = self.bindings.iter().filter(|b| b.group == LIVE_GROUP).collect();
            let resources = bindings.iter().map(|b| books.binding(kernel, &b.name, parities));
            let resources = resources.collect::<Option<Vec<_>>>().ok_or(GpuError::Missing(kernel.name()))?;
            let group = bind_group(device, Some(&self.label), layout, &bindings, resources);
            place.insert(group);
        }
        Ok(())
    }

    /// Sets pipeline and bindings for a pass.
    pub(super) fn set(&self, pass: &mut wgpu::ComputePass<'_>, place: &Place) -> Result<(), GpuError> {
        let bound = self.bound.as_ref().ok_or(GpuError::Missing(self.kernel.name()))?;
        pass.set_pipeline(&self.compiled.pipeline);
        for (group, bind_group) in (0..).zip(&bound.groups) {
            pass.set_bind_group(group, bind_group, &[]);
        }
        if let Some(group) = bound.live.get(&(place.parities() & self.lists)) {
            let offset = |name: &String| place.offset(self.kernel.program(), name);
            let offsets: Vec<u32> = bound.offsets.iter().filter_map(offset).collect();
            pass.set_bind_group(LIVE_GROUP, group, &offsets);
        }
        Ok(())
    }
}

/// Whether no index of this kernel needs a check: it is the kernel as this crate composes it for the plan's options,
/// even if the plan was changed since, and the data was validated for exactly these options.
fn is_proved(plan: &Plan, variant: &Variant, data: &SceneData) -> bool {
    variant.kernel.info().proof.holds(data, &variant.kernel.features(&plan.features))
        && Variant::new(variant.kernel, &plan.features, &live::lists(&plan.schedule.kernels(), &plan.features))
            .is_ok_and(|own| own.source == variant.source && own.bindings == variant.bindings)
}

fn view(binding: &Binding, streams: &[(Stream, StreamTexture)]) -> Option<wgpu::TextureView> {
    let of = |stream: Stream| streams.iter().find(|(other, _)| *other == stream).map(|(_, texture)| texture);
    match binding.resource {
        Resource::WriteStreams { first } => of(first).map(StreamTexture::view_of_all),
        _ => of(binding.stream()?).map(StreamTexture::view),
    }
}

#[cfg(test)]
mod tests {
    use raystep_scenes::{Camera, generate};

    use super::*;
    use crate::options::{Accelerator, Options, RaySource, ScheduleKind};
    use crate::plan::Limits;
    use crate::programs::closest_hit::kernels;

    /// A kernel compiled without checks is the very shader that the proof is about, and it runs on the very data.
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
                assert_eq!(is_proved(&plan, variant, &data), variant.kernel == kernels::FUSED, "{accelerator}");
            }
            let fused = plan.variant(kernels::FUSED).expect("fused");
            let mut changed = fused.clone();
            changed.source += "// not ours\n";
            assert!(!is_proved(&plan, &changed, &data), "{accelerator}: another text");
            let mut changed = fused.clone();
            changed.bindings.reverse();
            assert!(!is_proved(&plan, &changed, &data), "{accelerator}: other bindings");
            let mut resumes = plan.clone();
            resumes.features.resumes = true;
            let variant = Variant::new(kernels::FUSED, &resumes.features, &[]).expect("a variant");
            assert!(!is_proved(&resumes, &variant, &data), "{accelerator}: places that streams hold");
            let mut broken = data.clone();
            broken.packed_triangles.clear();
            assert!(!is_proved(&plan, fused, &broken), "{accelerator}: data that does not hold");
            if accelerator != Accelerator::Grid {
                let other = of_grid.variant(kernels::FUSED).expect("fused");
                assert!(!is_proved(&plan, other, &data), "{accelerator}: a shader of other options");
            }
        }
        let (plan, data) = plan(Accelerator::Grid, ScheduleKind::Second);
        assert!(plan.variants.iter().all(|variant| !is_proved(&plan, variant, &data)));
    }

    /// What is compiled for a device with few storage textures binds no more of them.
    #[test]
    fn no_pipeline_binds_more_storage_textures_than_there_are() {
        let Some(gpu) = crate::programs::grid_build::device::tests::gpu() else { return };
        let scene = generate::soup(300, 1).expect("soup");
        let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 8, height: 8 };
        let limits = Limits { storage_textures: 2, ..crate::renderer::Device::Gpu(gpu.clone()).limits() };
        for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
            for &schedule in ScheduleKind::ALL {
                let options = Options { accelerator, schedule, counters: true, ..Options::new(rays.clone()) };
                let (plan, data) = Plan::new(&scene, &options, &limits).expect("a plan");
                let plan = std::sync::Arc::new(plan);
                let executor = super::super::GpuExecutor::new(gpu.clone(), &plan, &data, false);
                let executor = pollster::block_on(executor).expect("an executor");
                let textures = |pipeline: &KernelPipeline| {
                    let is_one = |b: &&Binding| {
                        matches!(b.resource, Resource::WriteStream { .. } | Resource::WriteStreams { .. })
                    };
                    pipeline.bindings.iter().filter(is_one).count()
                };
                let most = executor.pipelines.0.iter().map(textures).max();
                assert_eq!(most, Some(2), "{accelerator} {schedule}");
            }
        }
    }
}
