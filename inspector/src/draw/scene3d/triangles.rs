//! The scene's triangles on the GPU.

use raystep_kernels::Gpu;
use raystep_kernels::scene_data::{SceneData, linear_to_srgb};

/// Most triangles that are drawn: 480 MB of corners. If there are more, every second, third, ... is drawn,
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

/// Texels of a texture's row, and its most rows: 128 MB.
const WIDTH: u32 = 2048;
const MOST_ROWS: u32 = 4096;

#[derive(Default)]
pub(super) struct Triangles {
    pub(super) shown: Shown,
    /// Triangles, as many as a texture takes, and their number of vertices.
    chunks: Vec<(wgpu::BindGroup, u32)>,
}

impl Triangles {
    /// In these colours, or those of their materials.
    pub(super) fn new(gpu: &Gpu, layout: &wgpu::BindGroupLayout, data: &SceneData, colors: Option<&[[u8; 4]]>) -> Self {
        let most = gpu.device.limits().max_texture_dimension_2d;
        let (width, rows) = (WIDTH.min(most), MOST_ROWS.min(most));
        let (triangles, _) = data.vertices.as_chunks::<9>();
        let shown = Shown::of(triangles.len());
        let picked: Vec<usize> = (0..triangles.len()).step_by(shown.every).collect();
        let mut chunks = Vec::new();
        for part in picked.chunks(((width * rows / 3) as usize).max(1)) {
            let mut texels: Vec<[u32; 4]> = Vec::with_capacity((3 * part.len()).next_multiple_of(width as usize));
            for &triangle in part {
                let painted = colors.and_then(|colors| colors.get(triangle)).copied();
                let color = u32::from_le_bytes(painted.unwrap_or_else(|| material_color(data, triangle)));
                let (corners, _) = triangles[triangle].as_chunks::<3>();
                texels.extend(corners.iter().map(|[x, y, z]| [x.to_bits(), y.to_bits(), z.to_bits(), color]));
            }
            let vertices = texels.len() as u32;
            texels.resize(texels.len().next_multiple_of(width as usize), [0; 4]);
            chunks.push((group(gpu, layout, width, &texels), vertices));
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

/// A texture with these texels, whole rows of them, to be bound.
fn group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, width: u32, texels: &[[u32; 4]]) -> wgpu::BindGroup {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("3D view, corners"),
        size: wgpu::Extent3d { width, height: texels.len() as u32 / width, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    gpu.write_texture(texture.as_image_copy(), texture.size(), bytemuck::cast_slice(texels));
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("3D view, triangles"),
        layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) }],
    })
}

/// The material's colour if it is known, paler so that the walk stands out; otherwise grey.
fn material_color(data: &SceneData, triangle: usize) -> [u8; 4] {
    const GREY: f32 = 0.72;
    let material = data.triangle_materials.get(triangle).map_or(0, |&material| material as usize);
    let base = data.materials.get(material).map_or([GREY; 3], |material| material.base_color.map(linear_to_srgb));
    let [r, g, b] = base.map(|v| ((0.55 * v + 0.45 * GREY).clamp(0.0, 1.0) * 255.0).round() as u8);
    [r, g, b, 255]
}
