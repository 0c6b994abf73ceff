//! The JSON of a GLB.

use super::vertices::{Primitive, attributes};
use super::{WriteError, finite};
use crate::{Camera, Light, Optics, Projection, Scene, Texture, Wrap};
use glam::{DVec3, Vec3};
use serde_json::{Map, Value, json};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The JSON under construction; offsets are counted as if the bytes were being written.
pub(super) struct Document<'a> {
    scene: &'a Scene,
    root: Map<String, Value>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    primitives: Vec<Value>,
    images: Vec<Vec<u8>>,
    bytes: u64,
}

impl<'a> Document<'a> {
    /// Everything except the mesh. Textures are encoded here, and come first in the binary chunk.
    pub(super) fn new(scene: &'a Scene) -> Result<Self, WriteError> {
        let mut d = Self {
            scene,
            root: Map::new(),
            views: Vec::new(),
            accessors: Vec::new(),
            primitives: Vec::new(),
            images: Vec::new(),
            bytes: 0,
        };
        d.root.insert("asset".into(), json!({ "version": "2.0", "generator": "raystep" }));
        for (index, texture) in scene.textures.iter().enumerate() {
            let png = encode(texture).map_err(|e| WriteError::Png { index, reason: e.to_string() })?;
            d.view(png.len() as u64, None);
            d.images.push(png);
        }
        d.list("images", (0..scene.textures.len()).map(|i| json!({ "bufferView": i, "mimeType": "image/png" })));
        d.list("samplers", scene.textures.iter().map(sampler));
        d.list("textures", (0..scene.textures.len()).map(|i| json!({ "source": i, "sampler": i })));
        d.list("materials", scene.materials.iter().map(material));
        Ok(d)
    }

    fn list(&mut self, name: &str, items: impl Iterator<Item = Value>) {
        let items: Vec<_> = items.collect();
        // glTF forbids empty arrays.
        if !items.is_empty() {
            self.root.insert(name.into(), items.into());
        }
    }

    fn view(&mut self, bytes: u64, target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes, "byteLength": bytes });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.bytes = (self.bytes + bytes).next_multiple_of(4);
        self.views.len() - 1
    }

    fn accessor(&mut self, count: usize, width: usize, component: u32, target: u32) -> usize {
        let size = if component == UNSIGNED_SHORT { 2 } else { 4 };
        let view = self.view(count as u64 * width as u64 * size, Some(target));
        let kind = ["SCALAR", "VEC2", "VEC3"][width - 1];
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    /// Adds a primitive whose bytes follow those added before, in the order of [`Primitive::write`].
    pub(super) fn primitive(&mut self, material: usize, primitive: &Primitive<'_>) {
        let count = primitive.vertices();
        let position = self.accessor(count, 3, FLOAT, ARRAY_BUFFER);
        self.accessors[position]["min"] = json!(primitive.min);
        self.accessors[position]["max"] = json!(primitive.max);
        let mut names = Map::from_iter([("POSITION".to_owned(), position.into())]);
        for (name, width) in attributes(self.scene) {
            names.insert(name.to_owned(), self.accessor(count, width, FLOAT, ARRAY_BUFFER).into());
        }
        let mut json = json!({ "attributes": names, "material": material });
        if let Some((count, size)) = primitive.indices() {
            let component = if size == 2 { UNSIGNED_SHORT } else { UNSIGNED_INT };
            json["indices"] = self.accessor(count, 1, component, ELEMENT_ARRAY_BUFFER).into();
        }
        self.primitives.push(json);
    }

    /// The node of the mesh, if there is one, at the scene's offset.
    fn mesh_node(&mut self) -> Vec<Value> {
        let (scene, primitives) = (self.scene, std::mem::take(&mut self.primitives));
        let is_moved = scene.offset != DVec3::ZERO;
        if primitives.is_empty() && !is_moved {
            return Vec::new();
        }
        let mut node = json!({ "name": scene.name });
        if !primitives.is_empty() {
            self.root.insert("meshes".into(), json!([{ "name": scene.name, "primitives": primitives }]));
            node["mesh"] = 0.into();
        }
        if is_moved {
            node["translation"] = json!(scene.offset.to_array());
        }
        vec![node]
    }

    /// The JSON padded with spaces to a multiple of 4, the images, and the bytes that follow the JSON.
    pub(super) fn finish(mut self) -> (Vec<u8>, Vec<Vec<u8>>, u64) {
        let scene = self.scene;
        let mut nodes = self.mesh_node();
        let size = bounds_size(scene);
        self.list("cameras", scene.cameras.iter().map(|c| camera(c, size)));
        nodes.extend(
            scene.cameras.iter().enumerate().map(
                |(i, c)| json!({ "name": c.name, "camera": i, "matrix": matrix(c.right, c.up, -c.forward, c.eye) }),
            ),
        );
        if !scene.lights.is_empty() {
            let lights: Vec<_> = scene.lights.iter().map(light).collect();
            self.root.insert("extensions".into(), json!({ "KHR_lights_punctual": { "lights": lights } }));
            nodes.extend(scene.lights.iter().enumerate().map(|(i, l)| {
                let mut node = placed(l);
                node["extensions"] = json!({ "KHR_lights_punctual": { "light": i } });
                node
            }));
        }
        let is_glass = |m: &crate::Material| matches!(m.optics, Optics::Dielectric { .. });
        let of_glass: &[&str] = match scene.materials.iter().any(is_glass) {
            true => &["KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"],
            false => &[],
        };
        let of_glow: &[&str] = match scene.materials.iter().any(|m| strength_of(m) > 1.0) {
            true => &["KHR_materials_emissive_strength"],
            false => &[],
        };
        let of_lights: &[&str] = if scene.lights.is_empty() { &[] } else { &["KHR_lights_punctual"] };
        let extensions = [of_lights, of_glow, of_glass].concat();
        if !extensions.is_empty() {
            self.root.insert("extensionsUsed".into(), json!(extensions));
        }
        let roots = if scene.offset == DVec3::ZERO { (0..nodes.len()).collect() } else { put_below_first(&mut nodes) };
        // A file without scenes is valid; a scene without nodes is valid, too, but some readers reject it.
        if !nodes.is_empty() {
            self.root.insert("scenes".into(), json!([{ "name": scene.name, "nodes": roots }]));
            self.root.insert("scene".into(), 0.into());
        }
        self.list("nodes", nodes.into_iter());
        let (accessors, views, bytes) =
            (std::mem::take(&mut self.accessors), std::mem::take(&mut self.views), self.bytes);
        self.list("accessors", accessors.into_iter());
        self.list("bufferViews", views.into_iter());
        if bytes > 0 {
            self.root.insert("buffers".into(), json!([{ "byteLength": bytes }]));
        }
        let mut text = Value::Object(self.root).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        (text, self.images, bytes)
    }
}

/// Makes all other nodes children of the first, whose translation is added to nothing here, so that each coordinate is
/// read back as it is. Returns the roots.
fn put_below_first(nodes: &mut [Value]) -> Vec<usize> {
    let others: Vec<_> = (1..nodes.len()).collect();
    if let (Some(first), false) = (nodes.first_mut(), others.is_empty()) {
        first["children"] = others.into();
    }
    vec![0]
}

/// A factor in short form, 0.73 instead of 0.7300000190734863, if that reads back as the same f32.
fn short(x: f32) -> f64 {
    format!("{x}").parse().ok().filter(|&d: &f64| d as f32 == x).unwrap_or_else(|| x.into())
}

fn material(m: &crate::Material) -> Value {
    let [r, g, b] = m.base_color.map(short);
    // Rough and not metallic, so that other viewers also show a Lambertian surface.
    let (metallic, roughness) = match m.optics {
        Optics::Diffuse => (0, json!(1)),
        Optics::Rough => (1, json!(0.5)),
        Optics::Mirror => (1, json!(0)),
        Optics::Dielectric { .. } => (0, json!(0)),
    };
    let mut pbr = json!({ "baseColorFactor": [r, g, b, 1], "metallicFactor": metallic, "roughnessFactor": roughness });
    if let Some(texture) = m.texture {
        pbr["baseColorTexture"] = json!({ "index": texture });
    }
    let mut json = json!({ "name": m.name, "pbrMetallicRoughness": pbr });
    let strength = strength_of(m);
    if m.emissive != [0.0; 3] {
        json["emissiveFactor"] = json!(m.emissive.map(|light| short(light / strength)));
    }
    if m.double_sided {
        json["doubleSided"] = true.into();
    }
    let mut extensions = Map::new();
    if let Optics::Dielectric { ior, is_thin } = m.optics {
        extensions.insert("KHR_materials_ior".into(), json!({ "ior": short(ior) }));
        extensions.insert("KHR_materials_transmission".into(), json!({ "transmissionFactor": 1 }));
        extensions.insert("KHR_materials_volume".into(), json!({ "thicknessFactor": if is_thin { 0 } else { 1 } }));
    }
    if strength > 1.0 {
        extensions.insert("KHR_materials_emissive_strength".into(), json!({ "emissiveStrength": strength }));
    }
    if !extensions.is_empty() {
        json["extensions"] = extensions.into();
    }
    json
}

/// What light is divided by, as its factors are at most 1: a power of two, so that it is read back as it is.
fn strength_of(m: &crate::Material) -> f32 {
    let most = m.emissive.into_iter().fold(1.0f32, f32::max);
    let below = f32::from_bits(most.to_bits() & 0x7f80_0000);
    if below < most { 2.0 * below } else { below }
}

fn sampler(t: &Texture) -> Value {
    let wrap = |w| match w {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    };
    let filter = if t.linear { 9729 } else { 9728 };
    json!({ "magFilter": filter, "minFilter": filter, "wrapS": wrap(t.wrap_u), "wrapT": wrap(t.wrap_v) })
}

fn encode(t: &Texture) -> Result<Vec<u8>, image::ImageError> {
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    let kind = image::ExtendedColorType::Rgba8;
    image::ImageEncoder::write_image(encoder, t.texels.as_flattened(), t.width, t.height, kind)?;
    Ok(png)
}

fn light(l: &Light) -> Value {
    let (kind, color, intensity) = match *l {
        Light::Point { color, intensity, .. } => ("point", color, intensity),
        Light::Directional { color, intensity, .. } => ("directional", color, intensity),
        Light::Spot { color, intensity, .. } => ("spot", color, intensity),
    };
    let mut json = json!({ "type": kind, "color": color.map(short), "intensity": short(intensity) });
    if let Light::Spot { inner_cone, outer_cone, .. } = *l {
        json["spot"] = json!({ "innerConeAngle": short(inner_cone), "outerConeAngle": short(outer_cone) });
    }
    json
}

/// A node at the light's position; light travels along the node's −Z.
fn placed(l: &Light) -> Value {
    match *l {
        Light::Point { position, .. } => json!({ "name": "point light", "translation": position.map(short) }),
        Light::Directional { direction, .. } => {
            json!({ "name": "directional light", "matrix": aimed(direction, [0.0; 3]) })
        }
        Light::Spot { direction, position, .. } => {
            json!({ "name": "spot light", "matrix": aimed(direction, position) })
        }
    }
}

fn aimed(direction: [f32; 3], position: [f32; 3]) -> [f64; 16] {
    let back = -Vec3::from(direction).as_dvec3().normalize_or(DVec3::NEG_Y);
    let right = back.any_orthonormal_vector();
    matrix(right, back.cross(right), back, Vec3::from(position).as_dvec3())
}

/// Column by column, as in glTF.
fn matrix(x: DVec3, y: DVec3, z: DVec3, origin: DVec3) -> [f64; 16] {
    let [a, b, c, d] = [x.extend(0.0), y.extend(0.0), z.extend(0.0), origin.extend(1.0)].map(|v| v.to_array());
    // Adding 0 turns −0 into 0.
    std::array::from_fn(|i| [a, b, c, d][i / 4][i % 4] + 0.0)
}

/// raystep does not use clipping planes, but glTF requires them; they are set so that viewers show the whole scene.
fn camera(c: &Camera, size: f64) -> Value {
    match c.projection {
        Projection::Perspective { vertical_fov } => {
            json!({ "name": c.name, "type": "perspective", "perspective": { "yfov": vertical_fov, "znear": size * 1e-4 } })
        }
        Projection::Orthographic { half_height } => {
            let volume = json!({ "xmag": half_height, "ymag": half_height, "znear": 0, "zfar": size * 10.0 });
            json!({ "name": c.name, "type": "orthographic", "orthographic": volume })
        }
    }
}

fn bounds_size(scene: &Scene) -> f64 {
    let b = scene.bounds();
    let size = if b.is_empty() { 0.0 } else { (b.max.as_dvec3() - b.min.as_dvec3()).length() };
    if size > 0.0 { size } else { 1.0 }
}

/// Checks cameras and lights, whose fields differ by kind.
pub(super) fn check_placed(scene: &Scene) -> Result<(), WriteError> {
    super::each("cameras", &scene.cameras, "is not finite, or its angle or height is out of range", |c| {
        let axes = [c.eye, c.right, c.up, c.forward].iter().all(|v| v.is_finite());
        axes && match c.projection {
            Projection::Perspective { vertical_fov } => vertical_fov > 0.0 && vertical_fov < std::f64::consts::PI,
            Projection::Orthographic { half_height } => half_height > 0.0 && half_height.is_finite(),
        }
    })?;
    super::each("lights", &scene.lights, "is not finite, or its colour is outside [0, 1]", |l| {
        let (color, place, intensity) = match *l {
            Light::Point { position, color, intensity } => (color, position, intensity),
            Light::Directional { direction, color, intensity } => (color, direction, intensity),
            Light::Spot { position, direction, color, intensity, .. } => {
                return placed_well(color, position, intensity) && finite(&direction);
            }
        };
        placed_well(color, place, intensity)
    })?;
    super::each("lights", &scene.lights, "has a cone without 0 <= inner < outer <= pi/2", |l| match *l {
        Light::Spot { inner_cone, outer_cone, .. } => {
            inner_cone >= 0.0 && inner_cone < outer_cone && outer_cone <= std::f32::consts::FRAC_PI_2
        }
        _ => true,
    })
}

fn placed_well(color: [f32; 3], place: [f32; 3], intensity: f32) -> bool {
    color.iter().all(|c| (0.0..=1.0).contains(c)) && finite(&place) && intensity >= 0.0 && intensity.is_finite()
}
