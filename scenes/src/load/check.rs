//! Checks that every part of the loader shares: references, extensions, numbers; and the notes.

use super::LoadError;
use gltf::json::{Index, Root, validation::Checked};

/// Extensions that a file may require.
const SUPPORTED: [&str; 4] =
    ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_mesh_quantization", "KHR_texture_transform"];

/// An error at one place of the file.
pub(super) fn at(path: impl Into<String>, problem: impl Into<String>) -> LoadError {
    LoadError::Invalid { path: path.into(), problem: problem.into() }
}

/// What `index` refers to, or an error that says how many there are.
pub(super) fn get<'a, T, I>(list: &'a [T], index: Index<I>, path: &str, what: &str) -> Result<&'a T, LoadError> {
    list.get(index.value())
        .ok_or_else(|| at(path, format!("refers to {what} {index}, but the file has {} (counted from 0)", list.len())))
}

/// The value of an enumeration, or an error that lists what is known.
pub(super) fn known<T: Copy>(value: &Checked<T>, path: &str, expected: &str) -> Result<T, LoadError> {
    match value {
        Checked::Valid(value) => Ok(*value),
        Checked::Invalid => Err(at(path, format!("is not a known value; {expected} would be right"))),
    }
}

/// Refuses NaN and the infinities that numbers beyond f32 turn into.
pub(super) fn finite<const N: usize>(values: [f32; N], path: &str) -> Result<[f32; N], LoadError> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(values),
        Some(bad) => Err(at(path, format!("{bad} is not a finite 32-bit number"))),
    }
}

/// Required extensions must be known; used ones that are not get a note.
pub(super) fn extensions(root: &Root, notes: &mut Notes) -> Result<(), LoadError> {
    if let Some(name) = root.extensions_required.iter().find(|name| !SUPPORTED.contains(&name.as_str())) {
        return Err(LoadError::RequiredExtension(name.clone(), SUPPORTED.join(", ")));
    }
    for name in root.extensions_used.iter().filter(|name| !SUPPORTED.contains(&name.as_str())) {
        notes.add(format!("the extension {name} is ignored"));
    }
    Ok(())
}

/// Sentences to the user, each said once.
#[derive(Default)]
pub(super) struct Notes {
    said: Vec<String>,
    known: std::collections::HashSet<String>,
}

impl Notes {
    pub(super) fn add(&mut self, note: impl Into<String>) {
        let note = note.into();
        if self.known.insert(note.clone()) {
            self.said.push(note);
        }
    }

    pub(super) fn into_vec(self) -> Vec<String> {
        self.said
    }
}
