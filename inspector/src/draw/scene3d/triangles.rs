//! The scene's triangles on the GPU.

use raystep_kernels::scene_data::{SceneData, linear_to_srgb};

use crate::draw::picture::filled;

/// Most triangles that are drawn: 400 MB of vertices and colours. If there are more, every second, third, ... is drawn,
/// so that a dense surface gets holes but keeps its shape.
pub const MOST_TRIANGLES: usize = 10_000_000;

/// How many of a scene's triangles are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shown {
    /// Triangles drawn.
    pub drawn: usize,
    /// Triangles of the scene.
    pub of: usize,
    /// One of so many is drawn; 1 where all are.
    pub every: usize,
}

impl Shown {
    /// The selection for this many triangles.
    #[must_use]
    pub fn of(triangles: usize) -> Self {
        let every = triangles.div_ceil(MOST_TRIANGLES).max(1);
        Self { drawn: triangles.div_ceil(every), of: triangles, every }
    }
}

impl std::fmt::Display for Shown {
    /// Empty if all are drawn, otherwise a sentence for the user.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.every > 1 {
            write!(f, "the 3D view shows one in {} triangles: {} of {}", self.every, self.drawn, self.of)?;
        }
        Ok(())
    }
}

/// Bytes of a triangle's corners.
const CORNERS: usize = 36;

#[derive(Default)]
pub(super) struct Triangles {
    pub(super) shown: Shown,
    chunks: Vec<(wgpu::BindGroup, u32)>,
}

impl Triangles {
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        data: &SceneData,
    ) -> Self {
        let limits = device.limits();
        let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(128 << 20);
        let chunk = (binding as usize / CORNERS).max(1);
        let (corners, _) = data.vertices.as_chunks::<9>();
        let shown = Shown::of(corners.len());
        let mut chunks = Vec::new();
        let mut first = 0;
        while first < corners.len() {
            // Of this part, every nth.
            let end = first.saturating_add(chunk.saturating_mul(shown.every)).min(corners.len());
            let picked: Vec<[f32; 9]>;
            let part = if shown.every == 1 {
                &corners[first..end]
            } else {
                picked = corners[first..end].iter().step_by(shown.every).copied().collect();
                &picked
            };
            let colors: Vec<[u8; 4]> = (first..end).step_by(shown.every).map(|i| color(data, i)).collect();
            let buffer = |label, contents: &[u8]| filled(device, queue, label, contents, wgpu::BufferUsages::STORAGE);
            let corner_buffer = buffer("3D view, corners", bytemuck::cast_slice(part));
            let color_buffer = buffer("3D view, colors", bytemuck::cast_slice(&colors));
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("3D view, triangles"),
                layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: corner_buffer.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: color_buffer.as_entire_binding() },
                ],
            });
            chunks.push((group, 3 * part.len() as u32));
            first = end;
        }
        Self { shown, chunks }
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        for (group, vertices) in &self.chunks {
            pass.set_bind_group(1, group, &[]);
            pass.draw(0..*vertices, 0..1);
        }
    }
}

/// The material's colour if it is known, paler so that the walk stands out; otherwise grey.
fn color(data: &SceneData, triangle: usize) -> [u8; 4] {
    const GREY: f32 = 0.72;
    let material = data.triangle_materials.get(triangle).map_or(0, |&material| material as usize);
    let base = data.materials.get(material).map_or([GREY; 3], |material| material.base_color.map(linear_to_srgb));
    let [r, g, b] = base.map(|v| ((0.55 * v + 0.45 * GREY).clamp(0.0, 1.0) * 255.0).round() as u8);
    [r, g, b, 255]
}
