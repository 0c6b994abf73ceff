//! Scene data on a device.

use std::mem::offset_of;

use super::Gpu;
use super::buffers::filled_buffer;
use crate::options::scene_data::SceneDataKind;
use crate::plan::Plan;
use crate::scene_data::SceneData;
use crate::shared::address::list_side;
use crate::shared::scene::SceneInfo;

/// A uniform or a list of scene data.
#[derive(Clone)]
pub(super) enum Uploaded {
    /// A uniform, or a list in a storage buffer.
    Buffer(wgpu::Buffer),
    /// A list in a square texture.
    Texture(wgpu::Texture, wgpu::TextureView),
}

/// Uniforms and lists, by name.
pub(super) type AllUploaded = [(&'static str, Uploaded)];

/// The format of lists in textures.
const LIST_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

impl Uploaded {
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Buffer(buffer) => buffer.size(),
            Self::Texture(texture, _) => 4 * u64::from(texture.width()) * u64::from(texture.height()),
        }
    }

    pub(super) fn binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Texture(_, view) => wgpu::BindingResource::TextureView(view),
        }
    }

    fn texture(device: &wgpu::Device, label: &str, contents: &[u8]) -> Self {
        let side = list_side(contents.len() as u64 / 4) as u32;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: LIST_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        Self::Texture(texture, view)
    }

    /// Replaces its contents.
    fn write(&self, gpu: &Gpu, contents: &[u8]) {
        match self {
            Self::Buffer(buffer) => gpu.queue.write_buffer(buffer, 0, contents),
            Self::Texture(texture, _) => {
                // Whole rows, and what is left in the next one.
                let row = 4 * texture.width() as usize;
                let (rows, rest) = contents.split_at(contents.len() / row * row);
                let mut y = 0;
                for (texels, width) in [(rows, texture.width()), (rest, rest.len() as u32 / 4)] {
                    let height = (texels.len() / (4 * width as usize).max(1)) as u32;
                    if height > 0 {
                        let to = wgpu::TexelCopyTextureInfo {
                            origin: wgpu::Origin3d { x: 0, y, z: 0 },
                            ..texture.as_image_copy()
                        };
                        gpu.write_texture(to, wgpu::Extent3d { width, height, depth_or_array_layers: 1 }, texels);
                    }
                    y += height;
                }
            }
        }
    }
}

/// The scene data of a plan, with its contents; what another run has `uploaded` is shared.
pub(super) fn upload_scene<'a>(
    gpu: &Gpu,
    plan: &Plan,
    data: &SceneData,
    uploaded: impl Fn(&str) -> Option<&'a Uploaded>,
) -> Vec<(&'static str, Uploaded)> {
    let mut buffers = Vec::new();
    for planned in &plan.buffers {
        let Some(info) = plan.program.buffer(planned.what) else { continue };
        // Two runs may look at the scene from different places.
        if let Some(uploaded) = uploaded(planned.what).filter(|_| !info.is_of_view) {
            buffers.push((planned.what, uploaded.clone()));
            continue;
        }
        let contents = info.contents(data);
        let label = plan.label(planned.what);
        let uploaded = if !info.is_uniform && plan.features.scene_data == SceneDataKind::Textures {
            let texture = Uploaded::texture(&gpu.device, &label, contents);
            texture.write(gpu, contents);
            texture
        } else {
            let kind = if info.is_uniform { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
            let usage = kind | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
            Uploaded::Buffer(filled_buffer(&gpu.device, &label, contents, usage))
        };
        buffers.push((planned.what, uploaded));
    }
    buffers
}

/// Uploads what depends on the camera.
pub(super) fn upload_view(gpu: &Gpu, plan: &Plan, uploaded: &AllUploaded, data: &SceneData) {
    for (name, uploaded) in uploaded {
        if let Some(info) = plan.program.buffer(name).filter(|info| info.is_of_view) {
            uploaded.write(gpu, info.contents(data));
        }
    }
    upload_size(&gpu.queue, plan, uploaded);
}

/// Uploads the size of the streams, which differs from the data's if runs of several sizes share them.
pub(super) fn upload_size(queue: &wgpu::Queue, plan: &Plan, uploaded: &AllUploaded) {
    if let Some(scene) = buffer(uploaded, "scene") {
        let size = [plan.width, plan.height];
        queue.write_buffer(scene, offset_of!(SceneInfo, size) as u64, bytemuck::bytes_of(&size));
    }
}

/// A uniform, or a list in a storage buffer.
pub(super) fn buffer<'a>(uploaded: &'a AllUploaded, name: &str) -> Option<&'a wgpu::Buffer> {
    uploaded.iter().find_map(|(of, uploaded)| match uploaded {
        Uploaded::Buffer(buffer) if *of == name => Some(buffer),
        _ => None,
    })
}
