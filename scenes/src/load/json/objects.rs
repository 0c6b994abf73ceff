//! The objects of a glTF file, with the properties that are read.

use super::{Int, List, Number, Property, Text};
use gltf::json::extensions::scene::khr_lights_punctual::Type as LightType;
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;
use gltf::json::{accessor, camera};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Root<'a> {
    pub(crate) asset: Property<Asset>,
    pub(crate) extensions_used: List<String>,
    pub(crate) extensions_required: List<String>,
    pub(crate) scene: Property<Int>,
    pub(crate) scenes: List<Scene>,
    #[serde(borrow)]
    pub(crate) nodes: List<Node<'a>>,
    pub(crate) meshes: List<Mesh>,
    pub(crate) accessors: List<Accessor>,
    pub(crate) buffer_views: List<View>,
    #[serde(borrow)]
    pub(crate) buffers: List<Buffer<'a>>,
    #[serde(borrow)]
    pub(crate) materials: List<Material<'a>>,
    pub(crate) textures: List<Texture>,
    #[serde(borrow)]
    pub(crate) images: List<Image<'a>>,
    pub(crate) samplers: List<Sampler>,
    #[serde(borrow)]
    pub(crate) cameras: List<Camera<'a>>,
    pub(crate) skins: List<Skin>,
    pub(crate) animations: List<IgnoredAny>,
    pub(crate) extensions: Property<RootExtensions>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Asset {
    pub(crate) version: Property<String>,
    pub(crate) min_version: Property<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(crate) lights: Property<Lights>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Lights {
    pub(crate) lights: List<Light>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Light {
    #[serde(rename = "type")]
    pub(crate) kind: Property<Checked<LightType>>,
    pub(crate) color: Property<Vec<Number>>,
    pub(crate) intensity: Property<Number>,
    pub(crate) range: Property<IgnoredAny>,
    pub(crate) spot: Property<Spot>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Spot {
    pub(crate) inner_cone_angle: Property<Number>,
    pub(crate) outer_cone_angle: Property<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Scene {
    pub(crate) nodes: List<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Node<'a> {
    #[serde(borrow)]
    pub(crate) name: Property<Text<'a>>,
    pub(crate) children: List<Int>,
    pub(crate) mesh: Property<Int>,
    pub(crate) skin: Property<Int>,
    pub(crate) camera: Property<Int>,
    pub(crate) weights: Property<Vec<Number>>,
    pub(crate) matrix: Property<Vec<Number>>,
    pub(crate) translation: Property<Vec<Number>>,
    pub(crate) rotation: Property<Vec<Number>>,
    pub(crate) scale: Property<Vec<Number>>,
    pub(crate) extensions: Property<NodeExtensions>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(crate) light: Property<LightLink>,
    #[serde(rename = "KHR_node_visibility")]
    pub(crate) visibility: Property<Visibility>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(crate) instancing: Property<Instancing>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct LightLink {
    pub(crate) light: Property<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Visibility {
    pub(crate) visible: Property<bool>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Instancing {
    pub(crate) attributes: Property<InstanceAttributes>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "UPPERCASE")]
pub(crate) struct InstanceAttributes {
    pub(crate) translation: Property<Int>,
    pub(crate) rotation: Property<Int>,
    pub(crate) scale: Property<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Mesh {
    pub(crate) primitives: List<Primitive>,
    pub(crate) weights: Property<Vec<Number>>,
}

/// Accessors by the names of attributes.
pub(crate) type Attributes = BTreeMap<String, Property<Int>>;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Primitive {
    pub(crate) attributes: Property<Attributes>,
    pub(crate) indices: Property<Int>,
    pub(crate) material: Property<Int>,
    pub(crate) mode: Property<Int>,
    pub(crate) targets: List<Attributes>,
    pub(crate) extensions: Property<PrimitiveExtensions>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(crate) draco: Property<Draco>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Draco {
    pub(crate) buffer_view: Property<Int>,
    /// The compressed attributes' ids.
    pub(crate) attributes: Property<Attributes>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub(crate) buffer_view: Property<Int>,
    pub(crate) byte_offset: Property<Int>,
    pub(crate) component_type: Property<Int>,
    pub(crate) normalized: Property<bool>,
    pub(crate) count: Property<Int>,
    #[serde(rename = "type")]
    pub(crate) kind: Property<Checked<accessor::Type>>,
    pub(crate) min: Property<Vec<Number>>,
    pub(crate) max: Property<Vec<Number>>,
    pub(crate) sparse: Property<Sparse>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Sparse {
    pub(crate) count: Property<Int>,
    pub(crate) indices: Property<SparsePart>,
    pub(crate) values: Property<SparsePart>,
}

/// The indices of a sparse accessor, or their values, which have no type of their own.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct SparsePart {
    pub(crate) buffer_view: Property<Int>,
    pub(crate) byte_offset: Property<Int>,
    pub(crate) component_type: Property<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct View {
    pub(crate) buffer: Property<Int>,
    pub(crate) byte_offset: Property<Int>,
    pub(crate) byte_length: Property<Int>,
    pub(crate) byte_stride: Property<Int>,
    pub(crate) extensions: Property<ViewExtensions>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub(crate) ext: Property<Meshopt>,
    #[serde(rename = "KHR_meshopt_compression")]
    pub(crate) khr: Property<Meshopt>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Meshopt {
    pub(crate) buffer: Property<Int>,
    pub(crate) byte_offset: Property<Int>,
    pub(crate) byte_length: Property<Int>,
    pub(crate) byte_stride: Property<Int>,
    pub(crate) count: Property<Int>,
    pub(crate) mode: Property<String>,
    pub(crate) filter: Property<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Buffer<'a> {
    pub(crate) byte_length: Property<Int>,
    #[serde(borrow)]
    pub(crate) uri: Property<Text<'a>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Material<'a> {
    #[serde(borrow)]
    pub(crate) name: Property<Text<'a>>,
    pub(crate) alpha_mode: Property<Checked<AlphaMode>>,
    pub(crate) double_sided: Property<bool>,
    pub(crate) emissive_factor: Property<Vec<Number>>,
    pub(crate) pbr_metallic_roughness: Property<Pbr>,
    pub(crate) extensions: Property<MaterialExtensions>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Pbr {
    pub(crate) base_color_factor: Property<Vec<Number>>,
    pub(crate) base_color_texture: Property<TextureInfo>,
    pub(crate) metallic_factor: Property<Number>,
    pub(crate) roughness_factor: Property<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(crate) emissive_strength: Property<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior")]
    pub(crate) ior: Property<Ior>,
    #[serde(rename = "KHR_materials_transmission")]
    pub(crate) transmission: Property<Transmission>,
    #[serde(rename = "KHR_materials_volume")]
    pub(crate) volume: Property<Volume>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Ior {
    pub(crate) ior: Property<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Transmission {
    pub(crate) transmission_factor: Property<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Volume {
    pub(crate) thickness_factor: Property<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct EmissiveStrength {
    pub(crate) emissive_strength: Property<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub(crate) index: Property<Int>,
    pub(crate) tex_coord: Property<Int>,
    pub(crate) extensions: Property<InfoExtensions>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct InfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(crate) transform: Property<TextureTransform>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct TextureTransform {
    pub(crate) offset: Property<Vec<Number>>,
    pub(crate) rotation: Property<Number>,
    pub(crate) scale: Property<Vec<Number>>,
    pub(crate) tex_coord: Property<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Texture {
    pub(crate) source: Property<Int>,
    pub(crate) sampler: Property<Int>,
    pub(crate) extensions: Property<TextureExtensions>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub(crate) webp: Property<TextureSource>,
    #[serde(rename = "KHR_texture_basisu")]
    pub(crate) basisu: Property<TextureSource>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct TextureSource {
    pub(crate) source: Property<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Image<'a> {
    #[serde(borrow)]
    pub(crate) uri: Property<Text<'a>>,
    pub(crate) buffer_view: Property<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Sampler {
    pub(crate) mag_filter: Property<Int>,
    pub(crate) wrap_s: Property<Int>,
    pub(crate) wrap_t: Property<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Camera<'a> {
    #[serde(borrow)]
    pub(crate) name: Property<Text<'a>>,
    #[serde(rename = "type")]
    pub(crate) kind: Property<Checked<camera::Type>>,
    pub(crate) perspective: Property<Perspective>,
    pub(crate) orthographic: Property<Orthographic>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Perspective {
    pub(crate) yfov: Property<Number>,
    pub(crate) znear: Property<Number>,
    pub(crate) zfar: Property<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Orthographic {
    pub(crate) xmag: Property<Number>,
    pub(crate) ymag: Property<Number>,
    pub(crate) znear: Property<Number>,
    pub(crate) zfar: Property<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(crate) struct Skin {
    pub(crate) joints: List<Int>,
    pub(crate) inverse_bind_matrices: Property<Int>,
}
