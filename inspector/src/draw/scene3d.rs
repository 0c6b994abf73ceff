//! The scene and one ray's walk through it, in 3D.
//!
//! Drawn in this order: the scene's triangles, what fills areas (tested triangles, the current cell), then lines and
//! dots. What lies behind an opaque scene is drawn too, but faintly, so that the walk is never out of sight. Depth is 1
//! near the eye and 0 far away. Only what WebGPU and WebGL 2 have in common is used: 4 samples a pixel, and corners read
//! from textures, as many as they take.

mod overlay;
mod pipelines;
mod settings;
mod triangles;

use std::sync::Arc;

use glam::DVec3;
use raystep_kernels::Gpu;
use raystep_kernels::scene_data::SceneData;

use super::picture::filled;
use crate::orbit::{Lens, Orbit};
use crate::photons::Photons;
use crate::walk::{Aabb, Branch, WalkGeometry};
use overlay::{FillVertex, Frustum, LineInstance, Overlay};
use pipelines::{Pipelines, SAMPLES, View};
pub use settings::{PhotonPaint, Settings, TriangleStyle};
use triangles::Triangles;
pub use triangles::{MOST_TRIANGLES, Shown};

/// Draws a scene and a walk into textures.
pub struct Scene3d {
    gpu: Arc<Gpu>,
    pipelines: Pipelines,
    view: wgpu::Buffer,
    view_group: wgpu::BindGroup,
    triangles: Triangles,
    boxes: Vec<PaintedBox>,
    branches: Vec<Branch>,
    photons: Arc<Photons>,
    frustum: Option<Frustum>,
    bounds: Aabb,
    targets: Option<Targets>,
}

/// What a picture is drawn into before its samples are averaged.
struct Targets {
    size: [u32; 2],
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Scene3d {
    /// Creates the pipelines; there is nothing to draw yet.
    #[must_use]
    pub fn new(gpu: &Arc<Gpu>) -> Self {
        let device = &gpu.device;
        let pipelines = Pipelines::new(device);
        let view = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("3D view"),
            size: size_of::<View>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let view_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("3D view"),
            layout: &pipelines.view_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: view.as_entire_binding() }],
        });
        Self {
            gpu: gpu.clone(),
            pipelines,
            view,
            view_group,
            triangles: Triangles::default(),
            boxes: Vec::new(),
            branches: Vec::new(),
            photons: Arc::default(),
            frustum: None,
            bounds: Aabb { min: DVec3::ZERO, max: DVec3::ZERO },
            targets: None,
        }
    }

    /// Uploads a scene's triangles, once per scene. Returns how many of them are drawn.
    pub fn set_scene(&mut self, data: &SceneData) -> Shown {
        self.bounds = Aabb::of_vertices(&data.vertices);
        self.frustum = Frustum::of(data);
        self.paint(data, None, Vec::new());
        self.triangles.shown
    }

    /// Gives the scene's triangles these colours, or those of their materials again, and shows these boxes.
    pub fn paint(&mut self, data: &SceneData, colors: Option<&[[u8; 4]]>, boxes: Vec<PaintedBox>) {
        self.boxes = boxes;
        // The old textures are freed first: both may not fit.
        self.triangles = Triangles::default();
        self.triangles = Triangles::new(&self.gpu, &self.pipelines.triangles_layout, data, colors);
    }

    /// Shows these rays of a light tree.
    pub fn show_light(&mut self, branches: Vec<Branch>) {
        self.branches = branches;
    }

    /// Shows these photons.
    pub fn show_photons(&mut self, photons: Arc<Photons>) {
        self.photons = photons;
    }

    /// The box of the scene's triangles, in traced units, for framing.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// How many of the scene's triangles are drawn.
    #[must_use]
    pub fn shown(&self) -> Shown {
        self.triangles.shown
    }

    /// Draws into `target`, a view of a texture of [`FORMAT`](crate::draw::picture::FORMAT) and of `size` pixels. The
    /// camera is in traced units. A size of 0 draws nothing.
    pub fn draw(
        &mut self,
        target: &wgpu::TextureView,
        size: [u32; 2],
        camera: &Orbit,
        walk: Option<&WalkGeometry>,
        around: &Around,
        settings: &Settings,
    ) {
        if size.contains(&0) {
            return;
        }
        let center = self.bounds.center().as_vec3();
        let view = view(camera, settings, around.cut.filter(|_| settings.cut), &self.bounds, size);
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        let over = (&self.branches[..], &*self.photons);
        let mut overlay = Overlay::new(walk, over, &self.bounds, self.frustum.as_ref(), settings, center.as_dvec3());
        overlay.boxes(&self.boxes);
        if let Some(marked) = &around.marked {
            overlay.mark(marked, settings);
        }
        let lines = self.buffer("lines", bytemuck::cast_slice::<LineInstance, u8>(&overlay.lines));
        let fills = self.buffer("fills", bytemuck::cast_slice::<FillVertex, u8>(&overlay.fills));

        let targets = match self.targets.take().filter(|targets| targets.size == size) {
            Some(targets) => targets,
            None => Targets::new(&self.gpu.device, size),
        };
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("3D view") });
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("3D view"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &targets.color,
                    depth_slice: None,
                    resolve_target: Some(target),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(settings.background()),
                        store: wgpu::StoreOp::Discard,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &targets.depth,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_bind_group(0, &self.view_group, &[]);
            if let Some(pipeline) = self.pipelines.of_triangles(settings.triangles) {
                pass.set_pipeline(pipeline);
                self.triangles.draw(&mut pass);
            }
            for hidden in [true, false] {
                if let Some(fills) = &fills {
                    pass.set_pipeline(if hidden { &self.pipelines.hidden_fills } else { &self.pipelines.fills });
                    pass.set_vertex_buffer(0, fills.slice(..));
                    pass.draw(0..overlay.fills.len() as u32, 0..1);
                }
            }
            for hidden in [true, false] {
                if let Some(lines) = &lines {
                    pass.set_pipeline(if hidden { &self.pipelines.hidden_lines } else { &self.pipelines.lines });
                    pass.set_vertex_buffer(0, lines.slice(..));
                    pass.draw(0..6, 0..overlay.lines.len() as u32);
                }
            }
        }
        #[expect(clippy::disallowed_methods, reason = "drawn on the thread of the window")]
        self.gpu.queue.submit([encoder.finish()]);
        self.targets = Some(targets);
    }

    fn buffer(&self, label: &str, contents: &[u8]) -> Option<wgpu::Buffer> {
        if contents.is_empty() {
            return None;
        }
        Some(filled(&self.gpu.device, &self.gpu.queue, label, contents, wgpu::BufferUsages::VERTEX))
    }
}

/// What a picture shows beside the scene and the walk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Around {
    /// What was picked.
    pub marked: Option<Marked>,
    /// Triangles nearer than this are cut away, as a distance from the origin along the view's direction.
    pub cut: Option<f64>,
}

/// A cell or node in a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaintedBox {
    /// The box.
    pub bounds: Aabb,
    /// sRGB-encoded, and the opacity of its faces.
    pub color: [u8; 4],
}

/// A part of the scene or of its structure, outlined in the colour of a selection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Marked {
    /// A cell or a node.
    Box(Aabb),
    /// A triangle.
    Triangle([DVec3; 3]),
}

fn view(camera: &Orbit, settings: &Settings, cut: Option<f64>, bounds: &Aabb, size: [u32; 2]) -> View {
    let (center, depth) = (bounds.center().as_vec3(), (bounds.max - bounds.min).length() as f32);
    let wgpu::Color { r, g, b, .. } = settings.background();
    let [width, height] = size.map(f64::from);
    let [right, up, forward] = camera.pose.axes();
    let clip = camera.clip_from_world(center.as_dvec3(), width / height);
    let is_perspective = matches!(camera.pose.lens, Lens::Perspective { .. });
    View {
        clip_from_world: clip.as_mat4().to_cols_array(),
        // The light comes from over the viewer's right shoulder: every side of a box has a different shade.
        light: (up * 0.45 + right * 0.25 - forward).normalize().as_vec3().to_array(),
        opacity: settings.opacity(),
        center: center.to_array(),
        edges: if settings.edges { 1.0 } else { 0.0 },
        size_px: [size[0] as f32, size[1] as f32],
        near: if is_perspective { camera.near() as f32 } else { 0.0 },
        hidden: 0.4,
        nearer: if is_perspective { [1.004, 0.0] } else { [1.0, 0.0015] },
        wire_px: settings.line_width_px,
        in_front: if cut.is_some() { settings.in_front() } else { 1.0 },
        front: forward.extend(cut.map_or(0.0, |cut| cut - forward.dot(center.as_dvec3()))).as_vec4().to_array(),
        haze: [r as f32, g as f32, b as f32, depth.max(f32::MIN_POSITIVE).recip()],
    }
}

impl Targets {
    fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let texture = |label, format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: SAMPLES,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let color = texture("3D view, samples", crate::draw::picture::FORMAT);
        Self { size, color, depth: texture("3D view, depth", pipelines::DEPTH_FORMAT) }
    }
}

#[cfg(test)]
mod tests;
