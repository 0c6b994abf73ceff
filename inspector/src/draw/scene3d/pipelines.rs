//! Shaders, and how they are put together.

use bytemuck::{Pod, Zeroable};

use super::overlay::{FillVertex, LineInstance};
use super::settings::TriangleStyle;
use crate::draw::picture::FORMAT;

/// Samples a pixel: as many as every WebGPU adapter has.
pub(super) const SAMPLES: u32 = 4;
/// Floats, for depths that go from 1 to 0.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The uniform `view`: see `view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct View {
    pub(super) clip_from_world: [f32; 16],
    pub(super) light: [f32; 3],
    pub(super) opacity: f32,
    pub(super) center: [f32; 3],
    pub(super) edges: f32,
    pub(super) size_px: [f32; 2],
    pub(super) near: f32,
    pub(super) hidden: f32,
    pub(super) nearer: [f32; 2],
    pub(super) wire_px: f32,
    pub(super) in_front: f32,
    pub(super) front: [f32; 4],
    pub(super) haze: [f32; 4],
}

pub(super) struct Pipelines {
    pub(super) view_layout: wgpu::BindGroupLayout,
    pub(super) triangles_layout: wgpu::BindGroupLayout,
    wireframe: wgpu::RenderPipeline,
    translucent: wgpu::RenderPipeline,
    opaque: wgpu::RenderPipeline,
    pub(super) lines: wgpu::RenderPipeline,
    pub(super) hidden_lines: wgpu::RenderPipeline,
    pub(super) fills: wgpu::RenderPipeline,
    pub(super) hidden_fills: wgpu::RenderPipeline,
}

/// What differs between them.
struct Variant<'a> {
    module: &'a wgpu::ShaderModule,
    layout: &'a wgpu::PipelineLayout,
    vertex: &'a str,
    fragment: &'a str,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    writes_depth: bool,
    compare: wgpu::CompareFunction,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let view_layout = layout(device, "3D view", wgpu::ShaderStages::VERTEX_FRAGMENT, uniform);
        let corners = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let triangles_layout = layout(device, "3D view, triangles", wgpu::ShaderStages::VERTEX, corners);
        let module = |label, source: &str| {
            let source = format!("{}\n{source}", include_str!("view.wgsl"));
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        };
        let triangles = module("triangles", include_str!("triangles.wgsl"));
        let overlay = module("overlay", include_str!("overlay.wgsl"));
        let pipeline_layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("3D view"),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let of_triangles = pipeline_layout(&[Some(&view_layout), Some(&triangles_layout)]);
        let of_overlay = pipeline_layout(&[Some(&view_layout)]);

        let in_front = wgpu::CompareFunction::GreaterEqual;
        let behind = wgpu::CompareFunction::Less;
        let scene = |fragment, writes_depth| {
            let (module, layout, vertex) = (&triangles, &of_triangles, "vs_triangle");
            let variant = Variant { module, layout, vertex, fragment, buffers: &[], writes_depth, compare: in_front };
            pipeline(device, &variant)
        };
        let drawn_over = |vertex, fragment, buffer: wgpu::VertexBufferLayout<'_>, compare| {
            let (module, layout, buffers) = (&overlay, &of_overlay, &[Some(buffer)]);
            pipeline(device, &Variant { module, layout, vertex, fragment, buffers, writes_depth: false, compare })
        };
        Self {
            wireframe: scene("fs_wire", false),
            translucent: scene("fs_solid", false),
            opaque: scene("fs_solid", true),
            lines: drawn_over("vs_line", "fs_line", LineInstance::layout(), in_front),
            hidden_lines: drawn_over("vs_line", "fs_line_hidden", LineInstance::layout(), behind),
            fills: drawn_over("vs_fill", "fs_fill", FillVertex::layout(), in_front),
            hidden_fills: drawn_over("vs_fill", "fs_fill_hidden", FillVertex::layout(), behind),
            view_layout,
            triangles_layout,
        }
    }

    pub(super) fn of_triangles(&self, style: TriangleStyle) -> Option<&wgpu::RenderPipeline> {
        match style {
            TriangleStyle::Hidden => None,
            TriangleStyle::Wireframe => Some(&self.wireframe),
            TriangleStyle::Translucent => Some(&self.translucent),
            TriangleStyle::Opaque => Some(&self.opaque),
        }
    }
}

fn layout(
    device: &wgpu::Device,
    label: &str,
    visibility: wgpu::ShaderStages,
    ty: wgpu::BindingType,
) -> wgpu::BindGroupLayout {
    let entries = [wgpu::BindGroupLayoutEntry { binding: 0, visibility, ty, count: None }];
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

fn pipeline(device: &wgpu::Device, variant: &Variant<'_>) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(variant.fragment),
        layout: Some(variant.layout),
        vertex: wgpu::VertexState {
            module: variant.module,
            entry_point: Some(variant.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: variant.buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(variant.writes_depth),
            depth_compare: Some(variant.compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: SAMPLES, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module: variant.module,
            entry_point: Some(variant.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: FORMAT,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    #[test]
    fn the_uniform_lies_as_the_shader_says() {
        macro_rules! members {
            ($($name:ident)*) => { [$((stringify!($name), offset_of!(View, $name))),*] };
        }
        let members =
            members!(clip_from_world light opacity center edges size_px near hidden nearer wire_px in_front front haze);
        crate::draw::uniforms::assert_lies_as(include_str!("view.wgsl"), "View", &members, size_of::<View>());
    }
}
