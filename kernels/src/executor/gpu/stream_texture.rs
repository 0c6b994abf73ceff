//! Where streams are on a device.

use super::stream_format;
use crate::executor::sizes::Sizes;
use crate::plan::Plan;
use crate::shader::first_layer;
use crate::tables::elements::Size;
use crate::tables::stream::Stream;

/// Where a stream is: in layers of a 2D-array texture, one per component, which it may share with other streams; or, if it
/// is drawn into, in a texture of one layer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct StreamTexture {
    texture: wgpu::Texture,
    first: u32,
    layers: u32,
}

impl StreamTexture {
    /// A texture that holds nothing else.
    #[must_use]
    pub fn whole(texture: wgpu::Texture) -> Self {
        let layers = texture.depth_or_array_layers();
        Self { texture, first: 0, layers }
    }

    /// The texture, with all of its layers.
    #[must_use]
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Texels per row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.texture.width()
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.texture.height()
    }

    /// Width, height, and the stream's own layers.
    #[must_use]
    pub fn size(&self) -> wgpu::Extent3d {
        wgpu::Extent3d { depth_or_array_layers: self.layers, ..self.texture.size() }
    }

    /// The format of its texels.
    #[must_use]
    pub fn format(&self) -> wgpu::TextureFormat {
        self.texture.format()
    }

    /// Bytes of the stream's own layers.
    pub(super) fn bytes(&self) -> u64 {
        bytes(self.size())
    }

    /// What copies to or from all of its layers name.
    #[must_use]
    pub fn as_image_copy(&self) -> wgpu::TexelCopyTextureInfo<'_> {
        self.copy_at(0, 0, 0)
    }

    /// What copies to or from a region name that begins at a texel of a layer of the stream.
    #[must_use]
    pub fn copy_at(&self, x: u32, y: u32, layer: u32) -> wgpu::TexelCopyTextureInfo<'_> {
        let origin = wgpu::Origin3d { x, y, z: self.first + layer };
        wgpu::TexelCopyTextureInfo { origin, ..self.texture.as_image_copy() }
    }

    /// A view of the stream's layers.
    #[must_use]
    pub fn view(&self) -> wgpu::TextureView {
        self.view_of(self.first, Some(self.layers))
    }

    /// A view of all layers of the texture.
    pub(super) fn view_of_all(&self) -> wgpu::TextureView {
        self.view_of(0, None)
    }

    fn view_of(&self, base_array_layer: u32, array_layer_count: Option<u32>) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            base_array_layer,
            array_layer_count,
            ..Default::default()
        })
    }
}

/// Bytes of texels with four bytes each.
pub(super) fn bytes(size: wgpu::Extent3d) -> u64 {
    4 * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
}

/// Textures for those of these streams whose elements have been counted.
pub(super) fn allocate(
    device: &wgpu::Device,
    plan: &Plan,
    sizes: &Sizes,
    streams: impl Iterator<Item = Stream>,
) -> Vec<(Stream, StreamTexture)> {
    let mut made: Vec<(Stream, StreamTexture)> = Vec::new();
    for stream in streams {
        let Some(size) = sizes.of(plan.program, stream.info().elements) else { continue };
        // Streams that share a texture are of the same elements, so that they are all new, or none is.
        let group = plan.sharing.of(&stream);
        let shared = made.iter().find(|(other, _)| group.contains(other)).map(|(_, made)| made.texture.clone());
        let texture = shared.unwrap_or_else(|| texture(device, plan, group, size));
        let (first, layers) = (first_layer(group, stream), stream.layers() as u32);
        made.push((stream, StreamTexture { texture, first, layers }));
    }
    made
}

fn texture(device: &wgpu::Device, plan: &Plan, group: &[Stream], size: Size) -> wgpu::Texture {
    use wgpu::TextureUsages as U;
    let names: Vec<&str> = group.iter().map(|stream| stream.name()).collect();
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&plan.label(&names.join(", "))),
        size: wgpu::Extent3d {
            width: size.width,
            height: size.height,
            depth_or_array_layers: group.iter().map(|stream| stream.layers() as u32).sum(),
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: stream_format(group[0]),
        usage: U::STORAGE_BINDING | U::TEXTURE_BINDING | U::COPY_SRC | U::COPY_DST,
        view_formats: &[],
    })
}
