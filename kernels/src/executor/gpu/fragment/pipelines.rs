//! Render pipelines of the draws, and the depth test between rays and kernels.

use std::borrow::Cow;

use super::bound::{Bindable, Bound, bind};
use super::streams::FORMAT;
use crate::executor::gpu::GpuError;
use crate::fragment::{DrawnKernel, ENTRY, Shader, depth_of};
use crate::options::mapping::{Cull, Update};
use crate::plan::{DrawnPlan, Plan};
use crate::program::Kernel;
use crate::tables::stream::Stream;

/// A quad of the image's size, at the depth of the kernel that is drawn.
const QUAD: &str = "override depth: f32;

@vertex
fn quad(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(2.0 * corner - 1.0, depth, 1.0);
}
";

const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Vertices of the quad, a strip of two triangles.
const CORNERS: u32 = 4;

/// A draw of a kernel.
pub(super) struct DrawPipeline {
    pub(super) label: String,
    pub(super) targets: Vec<Stream>,
    pipeline: wgpu::RenderPipeline,
    bound: Bound,
}

/// A kernel's draws.
pub(super) struct Drawn {
    pub(super) kernel: Kernel,
    /// The streams that it reads and writes.
    pub(super) updates: Vec<Stream>,
    pub(super) draws: Vec<DrawPipeline>,
}

impl Drawn {
    /// The streams that it writes.
    pub(super) fn writes(&self) -> impl Iterator<Item = Stream> + '_ {
        self.draws.iter().flat_map(|draw| draw.targets.iter().copied())
    }
}

/// The draw that turns states into depths.
struct Depth {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    bound: Bound,
}

/// The compute shader that counts rays.
struct Counter {
    pipeline: wgpu::ComputePipeline,
    bound: Bound,
    groups: [u32; 2],
}

/// Everything that draws and counts.
pub(super) struct Pipelines {
    pub(super) drawn: Vec<Drawn>,
    depth: Option<Depth>,
    counter: Option<Counter>,
    update: Update,
}

/// A query around a draw: its set, and an index.
#[derive(Clone, Copy)]
pub(super) enum Query<'a> {
    /// Whether it wrote any fragment.
    Occlusion(&'a wgpu::QuerySet, u32),
    /// How many fragments it ran.
    Fragments(&'a wgpu::QuerySet, u32),
}

impl Query<'_> {
    fn begin(&self, pass: &mut wgpu::RenderPass<'_>) {
        match *self {
            Self::Occlusion(_, index) => pass.begin_occlusion_query(index),
            Self::Fragments(set, index) => pass.begin_pipeline_statistics_query(set, index),
        }
    }

    fn end(&self, pass: &mut wgpu::RenderPass<'_>) {
        match *self {
            Self::Occlusion(..) => pass.end_occlusion_query(),
            Self::Fragments(..) => pass.end_pipeline_statistics_query(),
        }
    }

    /// The set that a render pass is begun with.
    fn occlusion_set(&self) -> Option<&wgpu::QuerySet> {
        match *self {
            Self::Occlusion(set, _) => Some(set),
            Self::Fragments(..) => None,
        }
    }
}

/// Draws the quad.
fn draw_quad(pass: &mut wgpu::RenderPass<'_>, query: Option<Query<'_>>) {
    if let Some(query) = &query {
        query.begin(pass);
    }
    pass.draw(0..CORNERS, 0..1);
    if let Some(query) = &query {
        query.end(pass);
    }
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, plan: &Plan, drawn: &DrawnPlan) -> Self {
        let quad = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("quad"),
            source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(QUAD)),
        });
        let is_tested = drawn.how.cull == Cull::EarlyZ;
        let kernels = drawn.kernels.iter().map(|kernel| kernel_pipelines(device, &quad, kernel, is_tested)).collect();
        let depth = drawn.depths.as_ref().map(|shader| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(&plan.label("depth")),
                size: wgpu::Extent3d { width: plan.width, height: plan.height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: DEPTH_FORMAT,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            let bound = Bound::new(device, shader, wgpu::ShaderStages::FRAGMENT);
            let state = depth_state(true, wgpu::CompareFunction::Always);
            let pipeline = pipeline(device, &quad, "depth", shader, &bound, 0, 0.0, Some(state));
            Depth { view: texture.create_view(&Default::default()), texture, pipeline, bound }
        });
        let counter = drawn.counter.as_ref().map(|shader| {
            let bound = Bound::new(device, shader, wgpu::ShaderStages::COMPUTE);
            let label = plan.label("count");
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&label),
                layout: Some(&bound.layout(device, &label)),
                module: &module(device, &label, &shader.source),
                entry_point: Some(ENTRY),
                compilation_options: Default::default(),
                cache: None,
            });
            let side = crate::shared::constants::LIST_SIDE;
            let groups = [plan.width, plan.height].map(|length| length.div_ceil(side));
            Counter { pipeline, bound, groups }
        });
        Self { drawn: kernels, depth, counter, update: drawn.how.update }
    }

    pub(super) fn depth_bytes(&self) -> Option<u64> {
        let bytes = |texture: &wgpu::Texture| 4 * u64::from(texture.width()) * u64::from(texture.height());
        self.depth.as_ref().map(|depth| bytes(&depth.texture))
    }

    pub(super) fn index(&self, kernel: Kernel) -> Option<usize> {
        self.drawn.iter().position(|drawn| drawn.kernel == kernel)
    }

    /// Whether a draw of depths comes before those of a kernel.
    pub(super) fn has_depth(&self) -> bool {
        self.depth.is_some()
    }

    /// Turns the states into depths.
    pub(super) fn draw_depth(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        with: &Bindable<'_>,
        query: Option<Query<'_>>,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> Result<(), GpuError> {
        let Some(depth) = &mut self.depth else { return Ok(()) };
        let groups = depth.bound.groups(with, "depth")?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depth"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth.view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            timestamp_writes,
            ..Default::default()
        });
        pass.set_pipeline(&depth.pipeline);
        bind(groups, with.slot, |index, group, offsets| pass.set_bind_group(index, group, offsets));
        draw_quad(&mut pass, query);
        Ok(())
    }

    /// Draws into the targets of a draw.
    pub(super) fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        (kernel, draw): (usize, usize),
        with: &Bindable<'_>,
        query: Option<Query<'_>>,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> Result<(), GpuError> {
        let name = self.drawn[kernel].kernel.name();
        let draw = &mut self.drawn[kernel].draws[draw];
        let is_swapped = self.update == Update::Swap;
        let mut targets = Vec::new();
        for &stream in &draw.targets {
            let textures = with.streams.get(stream).ok_or(GpuError::Missing(stream.name()))?;
            let index = if is_swapped { textures.other_index() } else { textures.holder };
            targets.push(Some(wgpu::RenderPassColorAttachment {
                view: textures.view(index),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            }));
        }
        let depth = self.depth.as_ref().map(|depth| wgpu::RenderPassDepthStencilAttachment {
            view: &depth.view,
            // Only tested.
            depth_ops: None,
            stencil_ops: None,
        });
        let groups = draw.bound.groups(with, name)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&draw.label),
            color_attachments: &targets,
            depth_stencil_attachment: depth,
            timestamp_writes,
            occlusion_query_set: query.as_ref().and_then(Query::occlusion_set),
            ..Default::default()
        });
        pass.set_pipeline(&draw.pipeline);
        bind(groups, with.slot, |index, group, offsets| pass.set_bind_group(index, group, offsets));
        draw_quad(&mut pass, query);
        Ok(())
    }

    /// Counts the rays in each state.
    pub(super) fn count(&mut self, encoder: &mut wgpu::CommandEncoder, with: &Bindable<'_>) -> Result<(), GpuError> {
        let Some(Counter { pipeline, bound, groups: [x, y] }) = &mut self.counter else { return Ok(()) };
        let groups = bound.groups(with, "count")?;
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("count"), timestamp_writes: None });
        pass.set_pipeline(pipeline);
        bind(groups, with.slot, |index, group, offsets| pass.set_bind_group(index, group, offsets));
        pass.dispatch_workgroups(*x, *y, 1);
        Ok(())
    }
}

fn kernel_pipelines(device: &wgpu::Device, quad: &wgpu::ShaderModule, drawn: &DrawnKernel, is_tested: bool) -> Drawn {
    let kernel = drawn.kernel;
    let depth = is_tested.then(|| depth_state(false, wgpu::CompareFunction::Equal));
    let draw = |draw: &crate::fragment::Draw| {
        let names: Vec<&str> = draw.targets.iter().map(|stream| stream.name()).collect();
        let label = format!("{}.{} to {}", kernel.program().name, kernel.name(), names.join(", "));
        let bound = Bound::new(device, &draw.shader, wgpu::ShaderStages::FRAGMENT);
        let targets = draw.targets.len();
        let pipeline = pipeline(device, quad, &label, &draw.shader, &bound, targets, depth_of(kernel), depth.clone());
        DrawPipeline { label, targets: draw.targets.clone(), pipeline, bound }
    };
    Drawn { kernel, updates: drawn.updates.clone(), draws: drawn.draws.iter().map(draw).collect() }
}

fn depth_state(is_written: bool, compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(is_written),
        depth_compare: Some(compare),
        stencil: Default::default(),
        bias: Default::default(),
    }
}

fn module(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(Cow::Borrowed(source));
    device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
}

#[expect(clippy::too_many_arguments, reason = "all differ between the draws")]
fn pipeline(
    device: &wgpu::Device,
    quad: &wgpu::ShaderModule,
    label: &str,
    shader: &Shader,
    bound: &Bound,
    targets: usize,
    depth: f32,
    depth_stencil: Option<wgpu::DepthStencilState>,
) -> wgpu::RenderPipeline {
    let constants = [("depth", f64::from(depth))];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&bound.layout(device, label)),
        vertex: wgpu::VertexState {
            module: quad,
            entry_point: Some("quad"),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
        depth_stencil,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module(device, label, &shader.source),
            entry_point: Some(ENTRY),
            compilation_options: Default::default(),
            targets: &vec![Some(FORMAT.into()); targets],
        }),
        multiview_mask: None,
        cache: None,
    })
}
