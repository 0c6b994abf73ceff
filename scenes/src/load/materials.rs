//! The materials in use. What is wrong with one has its default, and a texture that cannot be read is left out.

mod textures;

use super::check;
use super::images::Images;
use super::json::{self, Property, Root, Text};
use super::lost::Lost;
use super::notes::{Notes, Wrong};
use super::{LoadError, at};
use crate::{Material, Optics, Texture};
use gltf::json::material::AlphaMode;
use std::collections::{BTreeSet, HashMap};
pub(super) use textures::TexcoordUse;
use textures::Textures;

/// The materials and textures read, with a map from the file's ids.
pub(super) struct Materials {
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    /// Our material for each of the file's; `None` is the default material.
    ids: HashMap<Option<usize>, (u32, Option<TexcoordUse>)>,
}

impl Materials {
    /// Our material for the file's, and how it uses texture coordinates.
    pub(super) fn id(&self, material: Option<usize>) -> (u32, Option<TexcoordUse>) {
        self.ids.get(&material).copied().unwrap_or((0, None))
    }
}

/// Reads the materials `used` (`None` is the default one), in this order. If there are none, creates the default one,
/// since a scene has at least one.
pub(super) fn read<'a>(
    root: &Root<'a>,
    used: &BTreeSet<Option<usize>>,
    images: &Images<'a>,
    notes: &mut Notes,
) -> Materials {
    let mut out = Materials { materials: Vec::new(), textures: Vec::new(), ids: HashMap::new() };
    let mut textures = Textures::new(root, images);
    let default = BTreeSet::from([None]);
    for &index in if used.is_empty() { &default } else { used } {
        let (mut material, mut texcoords) = (Material::default(), None);
        if let Some(i) = index {
            match found(root, i) {
                Ok(json) => {
                    material = convert(i, json, notes);
                    let path = format!("materials[{i}].pbrMetallicRoughness");
                    match textures.of_material(json, &path, i, notes) {
                        Ok(None) => {}
                        Ok(Some((texture, usage))) => (material.texture, texcoords) = (Some(texture), Some(usage)),
                        Err(error) => notes.lost(Lost::Texture, (i, 0), error),
                    }
                }
                Err(error) => notes.lost(Lost::Material, (i, 0), error),
            }
        }
        out.ids.insert(index, (out.materials.len() as u32, texcoords));
        out.materials.push(material);
    }
    out.textures = textures.read;
    out
}

fn found<'a, 'b>(root: &'b Root<'a>, i: usize) -> Result<&'b json::Material<'a>, LoadError> {
    let count = root.materials.elements().len();
    root.materials.get(|| "materials".to_owned())?;
    match root.materials.elements().get(i) {
        Some(material) => material.need(|| format!("materials[{i}]")),
        None => Err(at("material", format!("refers to material {i}, but the file has {count} (counted from 0)"))),
    }
}

/// Everything except the texture.
fn convert(i: usize, json: &json::Material<'_>, notes: &mut Notes) -> Material {
    let path = |field: &'static str| move || format!("materials[{i}].{field}");
    let mut lost = |key: usize, error| notes.lost(Lost::Material, (i, key), error);
    let alpha = json.alpha_mode.known(path("alphaMode"), "OPAQUE, MASK or BLEND");
    let alpha = alpha.unwrap_or_else(|error| {
        lost(1, error);
        None
    });
    let has_alpha = alpha.is_some_and(|mode| mode != AlphaMode::Opaque);
    let pbr = json.pbr_metallic_roughness.get(path("pbrMetallicRoughness"));
    let base_path = path("pbrMetallicRoughness.baseColorFactor");
    let base_color = pbr.and_then(|pbr| pbr.map_or(Ok(None), |pbr| color(&pbr.base_color_factor, base_path)));
    let base_color = base_color.unwrap_or_else(|error| {
        lost(2, error);
        None
    });
    let emissive = emissive(json, path("emissiveFactor")).unwrap_or_else(|error| {
        lost(3, error);
        [0.0; 3]
    });
    let double_sided = json.double_sided.get(path("doubleSided")).unwrap_or_else(|error| {
        lost(4, error);
        None
    });
    let optics = optics(json, path("pbrMetallicRoughness, or an extension")).unwrap_or_else(|error| {
        lost(5, error);
        Optics::Diffuse
    });
    if has_alpha {
        notes.add("the alpha modes MASK and BLEND are shown as opaque");
    }
    let base_color = base_color.unwrap_or([1.0; 3]);
    let own = color(&json.emissive_factor, String::new).ok().flatten().unwrap_or_default();
    let outside = [base_color, own].iter().filter(|color| color.iter().any(check::is_outside)).count();
    notes.found(Wrong::FactorOutside, i, outside);
    let name = text(&json.name);
    Material { name, base_color, emissive, texture: None, double_sided: double_sided == Some(&true), optics }
}

/// A name, or nothing.
pub(super) fn text(name: &Property<Text<'_>>) -> String {
    name.ok().map(|name| name.0.clone().into_owned()).unwrap_or_default()
}

/// The first three numbers of a colour.
pub(super) fn color(
    numbers: &Property<Vec<json::Number>>,
    path: impl Fn() -> String,
) -> Result<Option<[f32; 3]>, LoadError> {
    let Some(color) = numbers.first_numbers::<3>(&path)? else { return Ok(None) };
    held(color, path).map(Some)
}

/// Numbers as 32-bit ones, if those hold them.
pub(super) fn held<const N: usize>(values: [f64; N], path: impl Fn() -> String) -> Result<[f32; N], LoadError> {
    match values.iter().find(|value| !(**value as f32).is_finite()) {
        None => Ok(values.map(|value| value as f32)),
        Some(bad) => Err(at(path(), format!("{bad} is not a finite 32-bit number"))),
    }
}

fn emissive(json: &json::Material<'_>, path: impl Fn() -> String) -> Result<[f32; 3], LoadError> {
    let Some(emissive) = json.emissive_factor.first_numbers::<3>(&path)? else { return Ok([0.0; 3]) };
    let extension = json.extensions.ok().and_then(|extensions| extensions.emissive_strength.ok());
    let strength = extension.map_or(Ok(1.0), |extension| extension.emissive_strength.number(1.0, &path))?;
    // As the factors of a shader, both are 32-bit numbers.
    let [emissive, strength] = [held(emissive, &path)?, held([strength; 3], &path)?];
    held([0, 1, 2].map(|i| f64::from(emissive[i] * strength[i])), path)
}

/// What a texture of 8 bits cannot tell from 0, or from 1.
const NEARLY: f64 = 1.0 / 255.0;

/// How the surface reflects and refracts light. Factors count without their textures.
fn optics(json: &json::Material<'_>, path: impl Fn() -> String) -> Result<Optics, LoadError> {
    let pbr = json.pbr_metallic_roughness.ok();
    let factor = |of: Option<&Property<json::Number>>| of.map_or(Ok(1.0), |factor| factor.number(1.0, &path));
    let metallic = factor(pbr.map(|pbr| &pbr.metallic_factor))?;
    let roughness = factor(pbr.map(|pbr| &pbr.roughness_factor))?;
    let extensions = json.extensions.ok();
    let transmission = extensions.and_then(|all| all.transmission.ok());
    let transmission = transmission.map_or(Ok(0.0), |it| it.transmission_factor.number(0.0, &path))?;
    let is_glass = transmission > 1.0 - NEARLY && metallic < NEARLY;
    if is_glass && roughness < NEARLY {
        let ior = extensions.and_then(|all| all.ior.ok()).map_or(Ok(1.5), |it| it.ior.number(1.5, &path))?;
        let volume = extensions.and_then(|all| all.volume.ok());
        let thickness = volume.map_or(Ok(0.0), |it| it.thickness_factor.number(0.0, &path))?;
        let [ior] = held([ior], &path)?;
        if ior < 1.0 {
            return Err(at(path(), format!("an index of refraction of {ior}: it must be 1 or more")));
        }
        return Ok(Optics::Dielectric { ior, is_thin: thickness <= 0.0 });
    }
    Ok(match metallic > 1.0 - NEARLY {
        true if roughness < NEARLY => Optics::Mirror,
        _ if transmission > 0.0 || metallic > 0.0 && roughness < 1.0 => Optics::Rough,
        _ => Optics::Diffuse,
    })
}
