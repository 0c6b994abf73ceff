//! Checks that all parts of the loader share: references, extensions, numbers; and the notes.

use super::LoadError;
use gltf::json::{Index, Root, validation::Checked};
use std::collections::{BTreeMap, HashSet};

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

/// Faults that are noted but do not prevent loading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Wrong {
    /// Vertices whose normal has no direction, by accessor.
    Normals,
    /// Vertices whose colour is not finite, by accessor.
    Colors,
    /// Vertices whose colour is outside [0, 1], by accessor.
    ColorsOutside,
    /// Vertices whose texture coordinates are not finite, by accessor.
    Texcoords,
    /// Accessors with elements outside their `min` and `max`, by accessor.
    Bounds,
    /// A material's colours outside [0, 1], by material.
    FactorOutside,
    /// Lights with a colour outside [0, 1], by light.
    LightOutside,
    /// Nodes with a matrix and also a translation, rotation or scale, by node.
    MatrixBesideParts,
    /// Nodes with a rotation that is not of length 1, by node.
    RotationNotUnit,
}

impl Wrong {
    /// The note for this number of occurrences.
    fn sentence(self, count: usize) -> String {
        let (one, many, rest) = match self {
            Self::Normals => ("normal", "normals", "no direction (zeros, NaN or infinities): drawn flat there"),
            Self::Colors => ("vertex colour", "vertex colours", "parts that are no numbers: drawn as 1"),
            Self::ColorsOutside => ("vertex colour", "vertex colours", "parts outside of 0 to 1: drawn as they are"),
            Self::Texcoords => ("texture coordinate", "texture coordinates", "parts that are no numbers: drawn as 0"),
            Self::Bounds => ("accessor", "accessors", "elements outside of min and max: drawn as they are"),
            Self::FactorOutside => {
                ("material factor", "material factors", "parts outside of 0 to 1: drawn as they are")
            }
            Self::LightOutside => ("light", "lights", "a colour outside of 0 to 1: drawn as it is"),
            Self::MatrixBesideParts => {
                ("node", "nodes", "a matrix beside a translation, rotation or scale: drawn by the matrix")
            }
            Self::RotationNotUnit => ("node", "nodes", "a rotation of another length than 1: drawn as if it were 1"),
        };
        if count == 1 { format!("1 {one} has {rest}") } else { format!("{count} {many} have {rest}") }
    }
}

/// Notes for the user, without duplicates.
#[derive(Default)]
pub(super) struct Notes {
    said: Vec<String>,
    known: HashSet<String>,
    /// How often each fault occurs in one part of the file; the part may be read repeatedly.
    found: BTreeMap<(Wrong, usize), usize>,
}

impl Notes {
    pub(super) fn add(&mut self, note: impl Into<String>) {
        let note = note.into();
        if self.known.insert(note.clone()) {
            self.said.push(note);
        }
    }

    /// Records that this fault occurs `count` times in the part of the file with this index.
    pub(super) fn found(&mut self, what: Wrong, index: usize, count: usize) {
        if count > 0 {
            self.found.insert((what, index), count);
        }
    }

    /// All notes: sentences first, then counted faults.
    pub(super) fn into_vec(self) -> Vec<String> {
        let mut counts: BTreeMap<Wrong, usize> = BTreeMap::new();
        for ((what, _), count) in self.found {
            *counts.entry(what).or_default() += count;
        }
        self.said.into_iter().chain(counts.into_iter().map(|(what, count)| what.sentence(count))).collect()
    }
}
