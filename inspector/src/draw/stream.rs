//! A stream as a picture, drawn from the stream's own texture: nothing is read back for it.

use std::sync::OnceLock;

use raystep_kernels::executor::gpu::StreamTexture;
use raystep_kernels::shared::constants::INF;
use raystep_kernels::tables::state::{States, Tag};
use raystep_kernels::tables::stream;
use raystep_kernels::{Stream, named};
use serde::{Deserialize, Serialize};

use super::picture::{FORMAT, filled};

/// How values become colours. NaN and infinities have special colours and a hatch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Colors {
    /// Counts and cost (van der Walt and Smith 2015).
    #[default]
    Viridis,
    /// As viridis, adapted to more kinds of colour vision (Nuñez, Anderton and Renslow 2018).
    Cividis,
    /// Distances along rays.
    Magma,
    /// Signed errors: blue below 0, orange above.
    Diverging,
    /// Black to white.
    Gray,
}

named!(Colors, Viridis "viridis", Cividis "cividis", Magma "magma", Diverging "blue–orange", Gray "gray");

impl Colors {
    /// The colour at `at` in \[0, 1\], sRGB.
    #[must_use]
    pub fn at(self, at: f64) -> [u8; 3] {
        let at = if at.is_nan() { 0.0 } else { at.clamp(0.0, 1.0) };
        let color = match self {
            Self::Viridis => colorous::VIRIDIS.eval_continuous(at),
            Self::Cividis => colorous::CIVIDIS.eval_continuous(at),
            Self::Magma => colorous::MAGMA.eval_continuous(at),
            // Both begin at nearly white.
            Self::Diverging if at < 0.5 => colorous::BLUES.eval_continuous(1.0 - 2.0 * at),
            Self::Diverging => colorous::ORANGES.eval_continuous(2.0 * at - 1.0),
            Self::Gray => {
                let level = (at * 255.0).round() as u8;
                return [level; 3];
            }
        };
        [color.r, color.g, color.b]
    }
}

/// The colour of a state: the same in every panel.
#[must_use]
pub fn state_color(states: States, tag: Tag) -> [u8; 3] {
    states.0.get(tag as usize).or(states.0.last()).map_or([0; 3], |state| state.colour)
}

/// The meaning of a component, which determines its colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// A float.
    Scalar,
    /// A count.
    Count,
    /// An id: equal or different.
    Id,
    /// Three layers, linear light.
    Color,
    /// A state's tag.
    Tag,
}

impl Meaning {
    /// The meaning of a layer; without a layer that of all together, if they are a colour.
    #[must_use]
    pub fn of(stream: Stream, layer: Option<usize>) -> Self {
        let Some(layer) = layer else {
            return if stream.is_color() { Self::Color } else { Self::of(stream, Some(0)) };
        };
        match stream.info().meaning.get(layer) {
            Some(stream::Meaning::Float | stream::Meaning::Distance | stream::Meaning::Light) => Self::Scalar,
            Some(stream::Meaning::Count) => Self::Count,
            Some(stream::Meaning::Tag) => Self::Tag,
            Some(stream::Meaning::Id) | None => Self::Id,
        }
    }
}

/// How a texture keeps a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// There is none.
    None,
    /// A layer of floats for each component.
    Floats,
    /// A layer of words for each.
    Words,
    /// One layer, with a component in each of its words: a stream that is drawn into.
    Packed,
}

impl Source {
    fn of(texture: &StreamTexture) -> Self {
        match texture.format() {
            wgpu::TextureFormat::R32Float => Self::Floats,
            wgpu::TextureFormat::Rgba32Uint => Self::Packed,
            _ => Self::Words,
        }
    }

    fn is_words(self) -> bool {
        matches!(self, Self::Words | Self::Packed)
    }
}

/// A picture to draw.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Which stream.
    pub stream: Stream,
    /// The states of its program.
    pub states: States,
    /// Its texture.
    pub texture: &'a StreamTexture,
    /// Subtracted from it, texel by texel: the same stream of another run.
    pub minus: Option<&'a StreamTexture>,
    /// The component; the first of three for a colour.
    pub layer: usize,
    /// What it means.
    pub meaning: Meaning,
    /// The values of the first and the last colour.
    pub range: [f32; 2],
    /// Factor of a colour.
    pub exposure: f32,
    /// Which colours.
    pub colors: Colors,
    /// Pixel of the target at which texel (0, 0) begins.
    pub offset: [f32; 2],
    /// Pixels of the target per texel.
    pub scale: f32,
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Uniform {
    offset: [f32; 2],
    scale: f32,
    layer: u32,
    range: [f32; 2],
    exposure: f32,
    unwritten: u32,
    inf: f32,
    rest: [u32; 3],
}

/// A texture to draw from, with the layout of a stream's own. It has at least two layers, and only those asked for are to
/// be written: a texture with one is no array to WebGL.
#[must_use]
pub fn drawable(
    device: &wgpu::Device,
    label: &str,
    format: wgpu::TextureFormat,
    size: wgpu::Extent3d,
) -> StreamTexture {
    StreamTexture::whole(device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { depth_or_array_layers: size.depth_or_array_layers.max(2), ..size },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    }))
}

/// Draws streams.
pub struct StreamPainter {
    device: wgpu::Device,
    queue: wgpu::Queue,
    module: wgpu::ShaderModule,
    /// By meaning, by how the stream is kept, and how the one that is subtracted.
    pipelines: [[[OnceLock<wgpu::RenderPipeline>; 4]; 4]; 5],
    layout: wgpu::BindGroupLayout,
    no_floats: wgpu::TextureView,
    no_words: wgpu::TextureView,
}

impl StreamPainter {
    /// Compiles its shader.
    #[must_use]
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("stream.wgsl"));
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let (floats, words) = (wgpu::TextureSampleType::Float { filterable: false }, wgpu::TextureSampleType::Uint);
        let types = [uniform, uniform, texture(floats), texture(words), texture(floats), texture(words)];
        let entries: Vec<_> = (0..)
            .zip(types)
            .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty,
                count: None,
            })
            .collect();
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("stream view"),
            entries: &entries,
        });
        let one = wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 };
        let nothing = |format| drawable(device, "no stream", format, one).view();
        Self {
            no_floats: nothing(wgpu::TextureFormat::R32Float),
            no_words: nothing(wgpu::TextureFormat::R32Uint),
            device: device.clone(),
            queue: queue.clone(),
            module,
            pipelines: Default::default(),
            layout,
        }
    }

    fn pipeline(&self, meaning: Meaning, [source, other]: [Source; 2]) -> &wgpu::RenderPipeline {
        let kept = &self.pipelines[meaning as usize][source as usize][other as usize];
        kept.get_or_init(|| self.compile(meaning, [source, other]))
    }

    fn compile(&self, meaning: Meaning, sources: [Source; 2]) -> wgpu::RenderPipeline {
        let [source, other] = sources.map(|source| f64::from(source as u8));
        let constants = [("MODE", f64::from(meaning as u8)), ("SOURCE", source), ("OTHER", other)];
        let pipeline_layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("stream view"),
            bind_group_layouts: &[Some(&self.layout)],
            immediate_size: 0,
        });
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("stream view"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("paint"),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Draws all of `target`, whose format is [`FORMAT`]; where there is no texel it is left transparent.
    pub fn draw(&self, picture: &Picture<'_>, target: &wgpu::TextureView) {
        let sources = [Source::of(picture.texture), picture.minus.map_or(Source::None, Source::of)];
        let uniform = Uniform {
            offset: picture.offset,
            scale: picture.scale,
            layer: picture.layer as u32,
            range: picture.range,
            exposure: picture.exposure,
            // The value of a missing id; a count cannot reach it.
            unwritten: u32::MAX,
            inf: INF,
            rest: [0; 3],
        };
        let colors: Vec<[f32; 4]> = (0..256)
            .map(|i| {
                let [r, g, b] = match picture.meaning {
                    Meaning::Tag => state_color(picture.states, i as Tag),
                    _ => picture.colors.at(i as f64 / 255.0),
                };
                [r, g, b, 255].map(|c| f32::from(c) / 255.0)
            })
            .collect();
        let buffer =
            |contents: &[u8]| filled(&self.device, &self.queue, "stream view", contents, wgpu::BufferUsages::UNIFORM);
        let (uniform, colors) = (buffer(bytemuck::bytes_of(&uniform)), buffer(bytemuck::cast_slice(&colors)));
        let (texture, minus) = (picture.texture.view(), picture.minus.map(StreamTexture::view));
        let minus = minus.as_ref();
        let or_none = |wanted: bool, view: Option<&wgpu::TextureView>, none: &wgpu::TextureView| {
            view.filter(|_| wanted).unwrap_or(none).clone()
        };
        let views = [
            or_none(sources[0] == Source::Floats, Some(&texture), &self.no_floats),
            or_none(sources[0].is_words(), Some(&texture), &self.no_words),
            or_none(sources[1] == Source::Floats, minus, &self.no_floats),
            or_none(sources[1].is_words(), minus, &self.no_words),
        ];
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let mut entries = vec![entry(0, uniform.as_entire_binding()), entry(1, colors.as_entire_binding())];
        entries.extend((2..).zip(&views).map(|(i, view)| entry(i, wgpu::BindingResource::TextureView(view))));
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("stream view"),
            layout: &self.layout,
            entries: &entries,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("stream view"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            pass.set_pipeline(self.pipeline(picture.meaning, sources));
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, 0..1);
        }
        #[expect(clippy::disallowed_methods, reason = "drawn on the thread of the window")]
        self.queue.submit([encoder.finish()]);
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    #[test]
    fn the_uniform_lies_as_the_shader_says() {
        let members = [
            ("offset", offset_of!(Uniform, offset)),
            ("scale", offset_of!(Uniform, scale)),
            ("layer", offset_of!(Uniform, layer)),
            ("lo", offset_of!(Uniform, range)),
            ("hi", offset_of!(Uniform, range) + 4),
            ("exposure", offset_of!(Uniform, exposure)),
            ("unwritten", offset_of!(Uniform, unwritten)),
            ("inf", offset_of!(Uniform, inf)),
        ];
        crate::draw::uniforms::assert_lies_as(include_str!("stream.wgsl"), "Picture", &members, size_of::<Uniform>());
    }
}
