//! Checks that all parts of the glTF loader share: errors, extensions, colours.

use super::LoadError;
use super::json::Root;
use super::notes::Notes;

/// Extensions that are read.
const SUPPORTED: [&str; 13] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Starts of the names of extensions without which every shape is in its place: those of materials, textures, lights,
/// animations and metadata. A file may require them.
const WITHOUT_SHAPE: [&str; 12] = [
    "KHR_materials_",
    "EXT_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_animation_",
    "KHR_audio",
    "KHR_technique",
    "KHR_xmp",
    "EXT_structural_metadata",
];

/// An error at one place of the file.
pub(super) fn at(path: impl Into<String>, problem: impl Into<String>) -> LoadError {
    LoadError::Invalid { path: path.into(), problem: problem.into() }
}

/// Whether the lack of a file or of memory is the reason. Then it is an error even if it costs only one shape: the file
/// is right, and what is missing can be given.
pub(super) fn is_lack(error: &LoadError) -> bool {
    !matches!(error, LoadError::Invalid { .. })
}

/// Whether a colour component is outside the specified range.
pub(super) fn is_outside(part: &f32) -> bool {
    !(0.0..=1.0).contains(part)
}

/// Rejects unknown required extensions that shapes may depend on, and notes unknown used ones.
pub(super) fn extensions(root: &Root<'_>, notes: &mut Notes) -> Result<(), LoadError> {
    let is_known = |name: &&String| SUPPORTED.contains(&name.as_str());
    let has_shape = |name: &&String| !WITHOUT_SHAPE.iter().any(|start| name.starts_with(start));
    let required = root.extensions_required.elements().iter().filter_map(|name| name.ok());
    if let Some(name) = required.clone().find(|name| !is_known(name) && has_shape(name)) {
        return Err(LoadError::RequiredExtension(name.clone(), SUPPORTED.join(", ")));
    }
    let used = root.extensions_used.elements().iter().filter_map(|name| name.ok());
    for name in used.chain(required).filter(|name| !is_known(name)) {
        notes.add(format!("the extension {name} is ignored"));
    }
    Ok(())
}
