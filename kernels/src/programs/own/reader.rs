//! What reads a user's `program.toml`, and what becomes of its names.

use std::ops::Range;
use std::sync::Arc;

use super::manifest::{Manifest, Named};
use crate::options::folder::Folder;
use crate::options::reasons::{Because, Reason, Run};
use crate::shader::{Mistake, ShaderError, place_in};
use crate::tables::elements::{Elements, Size};

/// Colours of kernels and states, readable on light and dark backgrounds (Okabe and Ito 2008, and between them).
const COLOURS: [[u8; 3]; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 140, 200],
    [200, 140, 0],
    [120, 94, 180],
    [140, 140, 60],
];

pub(super) fn colour(index: usize) -> [u8; 3] {
    COLOURS[index % COLOURS.len()]
}

pub(super) fn unused(_: &Run<'_>) -> Reason {
    (Because::Options, "no kernel of the schedule uses it")
}

pub(super) fn leaked(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

pub(super) fn all_leaked(texts: &[String]) -> &'static [&'static str] {
    Vec::leak(texts.iter().map(|text| leaked(text)).collect())
}

/// The names that there are, for a message about one that there is not.
pub(super) fn listed<'a>(what: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    if names.is_empty() {
        return format!("there are no {what}");
    }
    format!("the {what} are: {}", names.join(", "))
}

/// How many layers.
pub(super) fn layers_in_words(layers: usize) -> String {
    if layers == 1 { "1 layer".into() } else { format!("{layers} layers") }
}

/// A set of elements, and its size if it is known.
pub(super) type SizedSet = (&'static Elements, Option<Size>);

/// A manifest, and where it is from.
pub(super) struct Reader<'a> {
    pub(super) folder: &'a Arc<Folder>,
    pub(super) text: &'a str,
    pub(super) file: &'a str,
    pub(super) manifest: &'a Manifest,
}

impl Reader<'_> {
    pub(super) fn at(&self, range: Range<usize>, message: impl Into<String>) -> Mistake {
        Mistake { place: place_in(self.file, self.text, range.start), message: message.into() }
    }

    pub(super) fn shader(&self, error: ShaderError) -> Mistake {
        match error {
            ShaderError::Mistake(mistake) => *mistake,
            other => self.at(0..0, other.to_string()),
        }
    }

    /// What is said of a stream that is not in the manifest.
    pub(super) fn no_stream(&self, name: &str) -> String {
        format!("no stream is named {name}; {}", listed("streams", self.manifest.streams.names()))
    }

    /// What is said of a set that is not in the manifest.
    pub(super) fn no_set(&self, name: &str) -> String {
        format!("no set of elements is named {name}; {}", listed("sets", self.manifest.elements.names()))
    }

    /// What is said of a kernel that is not in the manifest.
    pub(super) fn no_kernel(&self, name: &str) -> String {
        format!("no kernel is named {name}; {}", listed("kernels", self.manifest.kernels.names()))
    }

    /// The names of a table: those of variables of WGSL.
    pub(super) fn names<T>(&self, table: &Named<T>, what: &str) -> Result<(), Mistake> {
        for (name, entry) in &table.0 {
            name_of(name, what).map_err(|message| self.at(entry.span(), message))?;
        }
        Ok(())
    }
}

/// Whether a name can be that of a variable of WGSL.
pub(super) fn name_of(name: &str, what: &str) -> Result<(), String> {
    let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c == '_' || c.is_ascii_alphanumeric())
        && name.len() <= 64
        && !name.contains("__")
        && !name.ends_with("_before");
    if is_name {
        return Ok(());
    }
    Err(format!(
        "{what} cannot be named {name}: names have letters, digits and single underscores, and do not end in _before"
    ))
}
