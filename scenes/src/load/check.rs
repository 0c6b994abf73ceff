//! Checks that all parts of the glTF loader share: references, extensions, numbers.

use super::LoadError;
use super::notes::Notes;
use gltf::json::{Index, Root, validation::Checked};

/// Extensions that a file may require.
const SUPPORTED: [&str; 4] =
    ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_mesh_quantization", "KHR_texture_transform"];

/// Extensions that a file may require because they only affect animations, which are ignored.
const OF_ANIMATIONS: [&str; 1] = ["KHR_animation_pointer"];

/// An error at one place of the file.
pub(super) fn at(path: impl Into<String>, problem: impl Into<String>) -> LoadError {
    LoadError::Invalid { path: path.into(), problem: problem.into() }
}

/// The element at `index`, or an error with the number of elements.
pub(super) fn get<'a, T, I>(list: &'a [T], index: Index<I>, path: &str, what: &str) -> Result<&'a T, LoadError> {
    list.get(index.value())
        .ok_or_else(|| at(path, format!("refers to {what} {index}, but the file has {} (counted from 0)", list.len())))
}

/// The value of an enumeration, or an error with the known values.
pub(super) fn known<T: Copy>(value: &Checked<T>, path: &str, expected: &str) -> Result<T, LoadError> {
    match value {
        Checked::Valid(value) => Ok(*value),
        Checked::Invalid => Err(at(path, format!("is not a known value; expected {expected}"))),
    }
}

/// Rejects NaN and infinities, which numbers beyond f32 turn into.
pub(super) fn finite<const N: usize>(values: [f32; N], path: &str) -> Result<[f32; N], LoadError> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(values),
        Some(bad) => Err(at(path, format!("{bad} is not a finite 32-bit number"))),
    }
}

/// Whether a colour component is outside the specified range.
pub(super) fn is_outside(part: &f32) -> bool {
    !(0.0..=1.0).contains(part)
}

/// Rejects unknown required extensions, and notes unknown used ones.
pub(super) fn extensions(root: &Root, notes: &mut Notes) -> Result<(), LoadError> {
    let is_known = |name: &&String| SUPPORTED.contains(&name.as_str());
    let is_harmless = |name: &String| OF_ANIMATIONS.contains(&name.as_str());
    if let Some(name) = root.extensions_required.iter().find(|name| !is_known(name) && !is_harmless(name)) {
        return Err(LoadError::RequiredExtension(name.clone(), SUPPORTED.join(", ")));
    }
    for name in root.extensions_used.iter().filter(|name| !is_known(name)) {
        notes.add(format!("the extension {name} is ignored"));
    }
    Ok(())
}
