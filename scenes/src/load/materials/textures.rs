//! The textures of materials: which image, and how it is sampled.

use crate::load::images::Images;
use crate::load::json::{self, Int, Root, Sampler, TextureInfo};
use crate::load::lost::Lost;
use crate::load::notes::Notes;
use crate::load::{LoadError, at};
use crate::{Texture, Wrap};
use gltf::json::texture::{MagFilter, WrappingMode};
use std::collections::HashMap;

/// How an image is sampled.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Sampling {
    wraps: [Wrap; 2],
    linear: bool,
}

/// How a base colour texture uses texture coordinates.
#[derive(Clone, Copy)]
pub(in crate::load) struct TexcoordUse {
    /// n of `TEXCOORD_n`.
    pub(in crate::load) set: u64,
    /// KHR_texture_transform: the columns of a 2 × 3 matrix.
    transform: Option<[[f64; 2]; 3]>,
}

impl TexcoordUse {
    /// The coordinates to sample at for the mesh's `uv`.
    pub(in crate::load) fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        let Some([x, y, offset]) = self.transform else { return uv };
        let [u, v] = uv.map(f64::from);
        [(x[0] * u + y[0] * v + offset[0]) as f32, (x[1] * u + y[1] * v + offset[1]) as f32]
    }
}

/// Reads textures, each once.
pub(super) struct Textures<'a, 'b> {
    root: &'a Root<'b>,
    images: &'a Images<'b>,
    /// Our texture of an image that is sampled in some way.
    made: HashMap<(usize, Sampling), u32>,
    /// Why images cannot be read.
    failed: HashMap<usize, LoadError>,
    pub(super) read: Vec<Texture>,
}

impl<'a, 'b> Textures<'a, 'b> {
    pub(super) fn new(root: &'a Root<'b>, images: &'a Images<'b>) -> Self {
        Self { root, images, made: HashMap::new(), failed: HashMap::new(), read: Vec::new() }
    }

    /// Our texture of a material whose roughness model is at `path`, if it has one.
    pub(super) fn of_material(
        &mut self,
        material: &json::Material<'_>,
        path: &str,
        i: usize,
        notes: &mut Notes,
    ) -> Result<Option<(u32, TexcoordUse)>, LoadError> {
        let Some(pbr) = material.pbr_metallic_roughness.ok() else { return Ok(None) };
        let path = format!("{path}.baseColorTexture");
        let Some(info) = pbr.base_color_texture.get(|| path.clone())? else { return Ok(None) };
        let index = *info.index.need(|| format!("{path}.index"))?;
        let texture = self.root.textures.at(index, &format!("{path}.index"), ("textures", "texture"))?;
        let usage = texcoord_use(info, &path)?;
        let sampling = self.sampling(texture, index).unwrap_or_else(|error| {
            notes.lost(Lost::Sampler, (i, 0), error);
            Sampling { wraps: [Wrap::Repeat; 2], linear: true }
        });
        self.of_sources(texture, index, sampling).map(|id| Some((id, usage)))
    }

    /// Our texture of the first of a texture's images that can be read.
    fn of_sources(&mut self, texture: &json::Texture, index: Int, sampling: Sampling) -> Result<u32, LoadError> {
        let path = format!("textures[{index}]");
        let extensions = texture.extensions.ok();
        let webp = extensions.and_then(|extensions| extensions.webp.ok()).map(|webp| &webp.source);
        let basisu = extensions.and_then(|extensions| extensions.basisu.ok()).map(|basisu| &basisu.source);
        let sources = [
            (webp, "extensions.EXT_texture_webp.source"),
            (Some(&texture.source), "source"),
            (basisu, "extensions.KHR_texture_basisu.source"),
        ];
        let mut first = None;
        for (source, name) in sources {
            let path = format!("{path}.{name}");
            let Some(source) = source.and_then(|source| source.get(|| path.clone()).transpose()) else { continue };
            match source.and_then(|source| self.of_image(*source, sampling, &path)) {
                Ok(id) => return Ok(id),
                Err(error) => first = first.or(Some(error)),
            }
        }
        Err(first.unwrap_or_else(|| at(path, "has no image")))
    }

    fn of_image(&mut self, index: Int, sampling: Sampling, path: &str) -> Result<u32, LoadError> {
        let image = self.root.images.at(index, path, ("images", "image"))?;
        let key = (index.index(), sampling);
        if let Some(known) = self.made.get(&key) {
            return Ok(*known);
        }
        if let Some(error) = self.failed.get(&index.index()) {
            return Err(error.clone());
        }
        let texels = self.images.read(index.index(), image).inspect_err(|error| {
            self.failed.insert(index.index(), error.clone());
        })?;
        let [wrap_u, wrap_v] = sampling.wraps;
        let id = self.read.len() as u32;
        self.read.push(Texture {
            width: texels.width,
            height: texels.height,
            texels: texels.texels,
            wrap_u,
            wrap_v,
            linear: sampling.linear,
        });
        self.made.insert(key, id);
        Ok(id)
    }

    fn sampling(&self, texture: &json::Texture, index: Int) -> Result<Sampling, LoadError> {
        let path = format!("textures[{index}].sampler");
        let default = Sampler::default();
        let (sampler, path) = match texture.sampler.get(|| path.clone())? {
            None => (&default, path),
            Some(sampler) => {
                (self.root.samplers.at(*sampler, &path, ("samplers", "sampler"))?, format!("samplers[{sampler}]"))
            }
        };
        let wrap = |property: &json::Property<Int>, field: &str| {
            let mode =
                property.known_or(WrappingMode::Repeat, || format!("{path}.{field}"), "33071, 33648 or 10497")?;
            Ok(match mode {
                WrappingMode::ClampToEdge => Wrap::Clamp,
                WrappingMode::MirroredRepeat => Wrap::Mirror,
                WrappingMode::Repeat => Wrap::Repeat,
            })
        };
        let filter = sampler.mag_filter.known_or(MagFilter::Linear, || format!("{path}.magFilter"), "9728 or 9729")?;
        Ok(Sampling {
            wraps: [wrap(&sampler.wrap_s, "wrapS")?, wrap(&sampler.wrap_t, "wrapT")?],
            linear: filter == MagFilter::Linear,
        })
    }
}

fn texcoord_use(info: &TextureInfo, path: &str) -> Result<TexcoordUse, LoadError> {
    let set = info.tex_coord.get(|| format!("{path}.texCoord"))?.map_or(0, |set| set.0);
    let path = format!("{path}.extensions.KHR_texture_transform");
    let json = info.extensions.get(|| path.clone())?.map_or(Ok(None), |all| all.transform.get(|| path.clone()))?;
    let Some(json) = json else { return Ok(TexcoordUse { set, transform: None }) };
    let own = json.tex_coord.get(|| format!("{path}.texCoord"))?.map(|set| set.0);
    let offset = json.offset.numbers(|| format!("{path}.offset"))?.unwrap_or_default();
    let [scale_u, scale_v] = json.scale.numbers(|| format!("{path}.scale"))?.unwrap_or([1.0; 2]);
    let (sin, cos) = json.rotation.number(0.0, || format!("{path}.rotation"))?.sin_cos();
    // offset * rotation * scale. The rotation is counter-clockwise as seen on the image, whose v points down, so its
    // sines have the signs required by the extension's text and used by all known viewers, not those of its GLSL
    // snippet.
    let transform = [[cos * scale_u, -sin * scale_u], [sin * scale_v, cos * scale_v], offset];
    Ok(TexcoordUse { set: own.unwrap_or(set), transform: Some(transform) })
}
