//! The materials in use, and their textures.

use super::LoadError;
use super::check;
use super::images::Images;
use super::notes::{Notes, Wrong};
use crate::{Material, Texture, Wrap};
use gltf::json::material::AlphaMode;
use gltf::json::texture::{self, MagFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::collections::{BTreeSet, HashMap};

/// What defines a texture: the image, and how it is sampled.
type TextureKey = (usize, [u8; 2], bool);

/// The materials and textures read, with a map from the file's ids.
pub(super) struct Materials {
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    /// Our material for each of the file's; `None` is the default material.
    ids: HashMap<Option<usize>, (u32, Option<TexcoordUse>)>,
}

/// How a base colour texture uses texture coordinates.
#[derive(Clone, Copy)]
pub(super) struct TexcoordUse {
    /// n of `TEXCOORD_n`.
    pub(super) set: u32,
    /// KHR_texture_transform: the columns of a 2 × 3 matrix.
    transform: Option<[[f64; 2]; 3]>,
}

impl TexcoordUse {
    /// The coordinates to sample at for the mesh's `uv`.
    pub(super) fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        let Some([x, y, offset]) = self.transform else { return uv };
        let [u, v] = uv.map(f64::from);
        [(x[0] * u + y[0] * v + offset[0]) as f32, (x[1] * u + y[1] * v + offset[1]) as f32]
    }
}

impl Materials {
    /// Our material for the file's, and how it uses texture coordinates.
    pub(super) fn id(&self, material: Option<usize>) -> (u32, Option<TexcoordUse>) {
        self.ids.get(&material).copied().unwrap_or((0, None))
    }
}

/// Reads the materials `used` (`None` is the default one), in this order. If there are none, creates the default one,
/// since a scene has at least one.
pub(super) fn read(
    root: &Root,
    used: &BTreeSet<Option<usize>>,
    images: &Images<'_>,
    notes: &mut Notes,
) -> Result<Materials, LoadError> {
    let mut out = Materials { materials: Vec::new(), textures: Vec::new(), ids: HashMap::new() };
    let mut made: HashMap<TextureKey, u32> = HashMap::new();
    let default = BTreeSet::from([None]);
    for &index in if used.is_empty() { &default } else { used } {
        let (mut material, info) = match index.and_then(|i| Some((i, root.materials.get(i)?))) {
            Some((i, material)) => {
                (convert(i, material, notes)?, material.pbr_metallic_roughness.base_color_texture.as_ref())
            }
            None => (Material::default(), None),
        };
        let mut texcoords = None;
        if let (Some(i), Some(info)) = (index, info) {
            let path = format!("materials[{i}].pbrMetallicRoughness.baseColorTexture");
            if let Some(key) = texture_key(root, info.index, &format!("{path}.index"), notes)? {
                let texture = match made.get(&key) {
                    Some(&texture) => texture,
                    None => {
                        let texture = texture(root, key, images)?;
                        out.textures.push(texture);
                        let id = out.textures.len() as u32 - 1;
                        made.insert(key, id);
                        id
                    }
                };
                material.texture = Some(texture);
                texcoords = Some(texcoord_use(info, &path)?);
            }
        }
        out.ids.insert(index, (out.materials.len() as u32, texcoords));
        out.materials.push(material);
    }
    Ok(out)
}

/// Everything except the texture.
fn convert(i: usize, material: &gltf::json::Material, notes: &mut Notes) -> Result<Material, LoadError> {
    let path = |field: &str| format!("materials[{i}].{field}");
    match check::known(&material.alpha_mode, &path("alphaMode"), "OPAQUE, MASK or BLEND")? {
        AlphaMode::Opaque => {}
        AlphaMode::Mask | AlphaMode::Blend => notes.add("the alpha modes MASK and BLEND are shown as opaque"),
    }
    let factor = material.pbr_metallic_roughness.base_color_factor.0;
    let [r, g, b, a] = check::finite(factor, &path("pbrMetallicRoughness.baseColorFactor"))?;
    let emissive_path = path("emissiveFactor");
    let emissive = check::finite(material.emissive_factor.0, &emissive_path)?;
    let outside = [[r, g, b, a].iter().any(check::is_outside), emissive.iter().any(check::is_outside)];
    notes.found(Wrong::FactorOutside, i, outside.iter().filter(|&&is_outside| is_outside).count());
    let extensions = material.extensions.as_ref();
    let strength = extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |e| e.emissive_strength.0);
    Ok(Material {
        name: material.name.clone().unwrap_or_default(),
        base_color: [r, g, b],
        emissive: check::finite(emissive.map(|e| e * strength), &emissive_path)?,
        texture: None,
        double_sided: material.double_sided,
    })
}

/// Image and sampling of a texture; `None`, with a note, if it has no image that we can read.
fn texture_key(
    root: &Root,
    index: Index<texture::Texture>,
    path: &str,
    notes: &mut Notes,
) -> Result<Option<TextureKey>, LoadError> {
    let texture = check::get(&root.textures, index, path, "texture")?;
    // gltf-json uses this for a missing source, for example if only an extension has one.
    if texture.source.value() == u32::MAX as usize {
        notes.add(format!("textures[{index}] has no PNG or JPEG image and is left out"));
        return Ok(None);
    }
    check::get(&root.images, texture.source, &format!("textures[{index}].source"), "image")?;
    let default = Sampler::default();
    let (sampler, path) = match texture.sampler {
        Some(sampler) => {
            let found = check::get(&root.samplers, sampler, &format!("textures[{index}].sampler"), "sampler")?;
            (found, format!("samplers[{sampler}]"))
        }
        None => (&default, String::new()),
    };
    let wrap = |mode: &Checked<WrappingMode>, field: &str| {
        check::known(mode, &format!("{path}.{field}"), "33071, 33648 or 10497").map(|mode| mode as u8)
    };
    let wraps = [wrap(&sampler.wrap_s, "wrapS")?, wrap(&sampler.wrap_t, "wrapT")?];
    let linear = match &sampler.mag_filter {
        Some(filter) => check::known(filter, &format!("{path}.magFilter"), "9728 or 9729")? == MagFilter::Linear,
        None => true,
    };
    Ok(Some((texture.source.value(), wraps, linear)))
}

fn texture(
    root: &Root,
    (image, [wrap_u, wrap_v], linear): TextureKey,
    images: &Images<'_>,
) -> Result<Texture, LoadError> {
    let index = Index::<gltf::json::Image>::new(image as u32);
    let found = check::get(&root.images, index, "images", "image")?;
    let texels = images.read(image, found)?;
    let wrap = |mode: u8| match mode {
        m if m == WrappingMode::ClampToEdge as u8 => Wrap::Clamp,
        m if m == WrappingMode::MirroredRepeat as u8 => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    Ok(Texture {
        width: texels.width,
        height: texels.height,
        texels: texels.texels,
        wrap_u: wrap(wrap_u),
        wrap_v: wrap(wrap_v),
        linear,
    })
}

fn texcoord_use(info: &texture::Info, path: &str) -> Result<TexcoordUse, LoadError> {
    let Some(transform) = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref()) else {
        return Ok(TexcoordUse { set: info.tex_coord, transform: None });
    };
    let path = format!("{path}.extensions.KHR_texture_transform");
    let offset = check::finite(transform.offset.0, &path)?.map(f64::from);
    let [scale_u, scale_v] = check::finite(transform.scale.0, &path)?.map(f64::from);
    let [angle] = check::finite([transform.rotation.0], &path)?.map(f64::from);
    let (sin, cos) = angle.sin_cos();
    // offset * rotation * scale. The rotation is counter-clockwise as seen on the image, whose v points down, so its
    // sines have the signs required by the extension's text and used by all known viewers, not those of its GLSL
    // snippet.
    let transform = [[cos * scale_u, -sin * scale_u], [sin * scale_v, cos * scale_v], offset];
    let set = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref()?.tex_coord);
    Ok(TexcoordUse { set: set.unwrap_or(info.tex_coord), transform: Some(transform) })
}
