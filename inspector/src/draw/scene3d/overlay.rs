//! What is drawn over the scene: lines, dots and filled triangles, relative to the scene's middle.

mod frustum;
mod light;
mod photons;
mod walk;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::settings::Settings;
use super::{Marked, PaintedBox};
use crate::photons::Photons;
use crate::walk::{Aabb, Branch, WalkGeometry};
pub(super) use frustum::Frustum;

/// A line with round ends; a dot where it has no length.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct LineInstance {
    a: [f32; 3],
    b: [f32; 3],
    color: [u8; 4],
    width_px: f32,
}

impl LineInstance {
    pub(super) fn layout() -> wgpu::VertexBufferLayout<'static> {
        const ATTRIBUTES: [wgpu::VertexAttribute; 4] =
            wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4, 3 => Float32];
        wgpu::VertexBufferLayout {
            array_stride: size_of::<Self>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &ATTRIBUTES,
        }
    }
}

/// A corner of a filled triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct FillVertex {
    position: [f32; 3],
    color: [u8; 4],
}

impl FillVertex {
    pub(super) fn layout() -> wgpu::VertexBufferLayout<'static> {
        const ATTRIBUTES: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Unorm8x4];
        wgpu::VertexBufferLayout {
            array_stride: size_of::<Self>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &ATTRIBUTES,
        }
    }
}

/// Red, green, blue and opacity, sRGB-encoded.
type Color = [u8; 4];

/// Colours that mean something, on dark and on light.
struct Palette {
    faint: Color,
    ray: Color,
    dim_ray: Color,
    current: Color,
    missed: Color,
    hit: Color,
    picked: Color,
    /// What no light comes through.
    dark: Color,
    /// The edge of a line of any colour.
    edge: Color,
    /// x, y and z.
    axes: [Color; 3],
    is_dark: bool,
}

impl Palette {
    fn of(settings: &Settings) -> Self {
        let is_dark = settings.is_dark;
        let pick = |dark: Color, light: Color| if is_dark { dark } else { light };
        Self {
            faint: pick([160, 170, 185, 130], [90, 98, 110, 150]),
            ray: pick([255, 255, 255, 255], [20, 22, 26, 255]),
            dim_ray: pick([255, 255, 255, 90], [20, 22, 26, 90]),
            current: pick([255, 214, 90, 255], [190, 130, 0, 255]),
            missed: pick([255, 150, 60, 255], [205, 95, 0, 255]),
            hit: pick([80, 225, 130, 255], [10, 140, 60, 255]),
            dark: pick([150, 130, 190, 255], [90, 70, 130, 255]),
            edge: pick([10, 12, 16, 255], [20, 22, 26, 255]),
            picked: pick([255, 80, 200, 255], [190, 0, 130, 255]),
            axes: [[240, 92, 92, 255], [110, 205, 90, 255], [95, 150, 255, 255]],
            is_dark,
        }
    }

    /// Viridis, from the first of `count` to the last, without its end that the background would swallow.
    fn in_order(&self, i: usize, count: usize) -> Color {
        let at = if count > 1 { i as f64 / (count - 1) as f64 } else { 0.5 };
        let shown = if self.is_dark { 0.3 + 0.7 * at } else { 0.9 * at };
        let colorous::Color { r, g, b } = colorous::VIRIDIS.eval_continuous(shown);
        [r, g, b, 255]
    }
}

fn faded(color: Color, opacity: f64) -> Color {
    [color[0], color[1], color[2], (f64::from(color[3]) * opacity) as u8]
}

/// Everything that is drawn over the scene, in the order in which it is drawn.
pub(super) struct Overlay {
    pub(super) lines: Vec<LineInstance>,
    pub(super) fills: Vec<FillVertex>,
    center: DVec3,
    width_px: f32,
}

impl Overlay {
    pub(super) fn new(
        walk: Option<&WalkGeometry>,
        (branches, photons): (&[Branch], &Photons),
        scene: &Aabb,
        frustum: Option<&Frustum>,
        settings: &Settings,
        center: DVec3,
    ) -> Self {
        let width_px = if settings.line_width_px.is_finite() { settings.line_width_px.clamp(0.25, 32.0) } else { 1.0 };
        let mut overlay = Self { lines: Vec::new(), fills: Vec::new(), center, width_px };
        let palette = Palette::of(settings);
        if settings.bounds {
            let bounds = walk.map_or(*scene, |walk| walk.bounds);
            overlay.edges(&bounds, 0.8, palette.faint);
        }
        if settings.axes {
            overlay.axes(scene, &palette);
        }
        if let Some(frustum) = frustum.filter(|_| settings.camera) {
            for [a, b] in frustum.lines(scene) {
                overlay.line(a, b, 1.0, palette.faint);
            }
        }
        if settings.light {
            overlay.light(branches, &palette);
        }
        overlay.photons(photons, settings, &palette);
        if let Some(walk) = walk {
            overlay.walk(walk, settings, &palette);
        }
        overlay
    }

    /// Fills boxes, with clearer edges.
    pub(super) fn boxes(&mut self, boxes: &[PaintedBox]) {
        for PaintedBox { bounds, color } in boxes {
            bounds.faces().into_iter().for_each(|face| self.triangle(face, *color));
            let [r, g, b, opacity] = *color;
            self.edges(bounds, 0.8, [r, g, b, opacity.saturating_mul(3)]);
        }
    }

    /// Outlines what was picked.
    pub(super) fn mark(&mut self, marked: &Marked, settings: &Settings) {
        let color = Palette::of(settings).picked;
        match *marked {
            Marked::Box(bounds) => {
                bounds.faces().into_iter().for_each(|face| self.triangle(face, faded(color, 0.10)));
                self.edges(&bounds, 2.4, color);
            }
            Marked::Triangle([a, b, c]) => {
                self.triangle([a, b, c], faded(color, 0.35));
                [[a, b], [b, c], [c, a]].into_iter().for_each(|[from, to]| self.line(from, to, 2.4, color));
            }
        }
    }

    fn axes(&mut self, scene: &Aabb, palette: &Palette) {
        let length = scene.radius() * 0.18;
        // Beside the corner that is in front at first, not in it: the scene's own edges are there.
        let from = DVec3::new(scene.min.x, scene.min.y, scene.max.z) + DVec3::new(-0.3, 0.0, 0.3) * length;
        for (axis, &color) in DVec3::AXES.iter().zip(&palette.axes) {
            self.line(from, from + *axis * length, 2.0, color);
        }
    }

    /// `widths` is in the width of the thinnest lines.
    fn line(&mut self, a: DVec3, b: DVec3, widths: f32, color: Color) {
        let [a, b] = [a, b].map(|p| (p - self.center).as_vec3().to_array());
        self.lines.push(LineInstance { a, b, color, width_px: widths * self.width_px });
    }

    fn dot(&mut self, at: DVec3, widths: f32, color: Color) {
        self.line(at, at, widths, color);
    }

    fn edges(&mut self, bounds: &Aabb, widths: f32, color: Color) {
        for [a, b] in bounds.edges() {
            self.line(a, b, widths, color);
        }
    }

    fn triangle(&mut self, corners: [DVec3; 3], color: Color) {
        for corner in corners {
            self.fills.push(FillVertex { position: (corner - self.center).as_vec3().to_array(), color });
        }
    }
}
