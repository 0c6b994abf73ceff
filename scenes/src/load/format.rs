//! Which format a file has: by its contents where they are certain, otherwise by the ending of its name.

use super::text::{self, starts_with};
use super::{LoadError, stl};
use serde::Deserialize;
use serde_json::value::RawValue;

/// Endings of the names of files that [`load`](crate::load) reads, in lower case.
pub const ENDINGS: [&str; 5] = ["gltf", "glb", "obj", "ply", "stl"];

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// glTF 2.0, as JSON or GLB.
    Gltf,
    Obj,
    Ply,
    Stl,
}

/// How files of other kinds start, and what they are.
const OTHERS: &[(&[u8], &str)] = &[
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "compressed by gzip"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (b"\xfd7zXZ", "compressed by xz"),
    (b"BZh", "compressed by bzip2"),
    (b"\x28\xb5\x2f\xfd", "compressed by Zstandard"),
    (b"version https://git-lfs", "a pointer of Git LFS, not the file itself"),
    (b"Kaydara FBX Binary", "FBX"),
    (b"; FBX", "FBX"),
    (b"PXR-USDC", "USD"),
    (b"#usda", "USD"),
    (b"BLENDER", "a file of Blender"),
    (b"OFF", "OFF"),
    (b"DRACO", "Draco"),
    (b"#VRML", "VRML"),
    (b"#X3D", "X3D"),
    (b"# vtk", "VTK"),
    (b"ISO-10303-21", "STEP"),
    (b"Ogawa", "Alembic"),
    (b"LASF", "LAS"),
    (b"ASTM-E57", "E57"),
    (b"%PDF", "PDF"),
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
];

/// XML, by what its first kilobyte contains.
const XMLS: &[(&[u8], &str)] = &[
    (b"<COLLADA", "Collada"),
    (b"<X3D", "X3D"),
    (b"<VTKFile", "VTK"),
    (b"<html", "HTML"),
    (b"<!DOCTYPE html", "HTML"),
];

impl Format {
    /// The format of a file of this name.
    pub(super) fn of(name: &str, bytes: &[u8]) -> Result<Self, LoadError> {
        if let Some(format) = Self::certain(bytes) {
            return Ok(format);
        }
        if text::is_utf16(bytes) {
            return Err(LoadError::Container("the file is UTF-16 text; save it as UTF-8".into()));
        }
        if text::trimmed(bytes).is_empty() {
            return Err(LoadError::Container("the file is empty".into()));
        }
        if let Some(kind) = other(bytes) {
            return Err(LoadError::OtherFormat(kind));
        }
        match ending(name) {
            Some("obj") => Ok(Self::Obj),
            Some("ply") => Ok(Self::Ply),
            Some("stl") => Ok(Self::Stl),
            _ => Err(LoadError::UnknownFormat),
        }
    }

    /// The format that the contents alone determine.
    pub(super) fn certain(bytes: &[u8]) -> Option<Self> {
        let text = text::trimmed(bytes);
        if bytes.starts_with(b"glTF") || text.starts_with(b"{") {
            Some(Self::Gltf)
        } else if text.starts_with(b"ply") && text.get(3).is_some_and(u8::is_ascii_whitespace) {
            Some(Self::Ply)
        } else if stl::is_certain(bytes) {
            Some(Self::Stl)
        } else {
            None
        }
    }
}

/// What a file of another kind is.
fn other(bytes: &[u8]) -> Option<&'static str> {
    let text = text::trimmed(bytes);
    if text.starts_with(b"<") {
        let start = text.get(..1024).unwrap_or(text);
        let found = XMLS.iter().find(|(word, _)| start.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word)));
        return Some(found.map_or("XML", |(_, kind)| kind));
    }
    // A chunk that is the whole file.
    let is_3ds = bytes.starts_with(b"MM") && bytes.get(2..6) == Some(&(bytes.len() as u32).to_le_bytes()[..]);
    let found = OTHERS.iter().find(|(magic, _)| starts_with(bytes, magic));
    found.map(|(_, kind)| *kind).or(is_3ds.then_some("3DS"))
}

/// Whether a file that could not be read is glTF 1.0, in which most lists are objects.
pub(super) fn is_gltf_1(bytes: &[u8]) -> bool {
    #[derive(Deserialize)]
    struct File<'a> {
        #[serde(borrow)]
        asset: Asset<'a>,
    }
    #[derive(Deserialize)]
    struct Asset<'a> {
        #[serde(borrow)]
        version: &'a RawValue,
    }
    if bytes.starts_with(b"glTF") {
        return bytes.get(4..8) == Some(&1_u32.to_le_bytes()[..]);
    }
    let text = std::str::from_utf8(text::trimmed(bytes)).unwrap_or_default();
    serde_json::from_str::<File<'_>>(text).is_ok_and(|file| file.asset.version.get().trim_matches('"').starts_with('1'))
}

/// The ending of a name, if it is one of [`ENDINGS`].
fn ending(name: &str) -> Option<&'static str> {
    let (_, found) = name.rsplit_once('.')?;
    ENDINGS.into_iter().find(|ending| found.eq_ignore_ascii_case(ending))
}

/// A file's name without such an ending.
pub(super) fn stem(name: &str) -> &str {
    ending(name).and_then(|ending| name.get(..name.len() - ending.len() - 1)).unwrap_or(name)
}
