//! Splits the file's bytes into its JSON and its BIN chunk.

use super::budget::Budget;
use super::json_path::path_of;
use super::{LoadError, at, repair};
use gltf::json::mesh::Primitive;
use gltf::json::{Accessor, Material, Node, Root};
use serde::Deserialize as _;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BIN_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// The parsed JSON and, if a GLB has one, the BIN chunk.
pub(super) fn parse<'a>(bytes: &'a [u8], budget: &Budget) -> Result<(Root, Option<&'a [u8]>), LoadError> {
    let (json, bin) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let root = parse_json(json, budget)?;
    let version = &root.asset.version;
    // Without a minVersion, every 2.x file can be read as 2.0.
    match &root.asset.min_version {
        Some(needed) if needed != "2.0" => {
            let problem = format!("is {needed:?}, which raystep cannot read; it reads 2.0");
            return Err(at("asset.minVersion", problem));
        }
        None if !version.starts_with("2.") => {
            return Err(at("asset", format!("is of glTF version {version:?}; expected 2.0")));
        }
        _ => {}
    }
    Ok((root, bin))
}

/// The JSON chunk and the BIN chunk, if there is one.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), LoadError> {
    let wrong = |what: String| LoadError::Container(format!("the GLB is broken: {what}"));
    let word = |offset: usize| {
        let word = bytes.get(offset..).and_then(|rest| rest.first_chunk::<4>());
        word.copied().map(u32::from_le_bytes)
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(wrong(format!("{} bytes are too few for its header of {HEADER_BYTES}", bytes.len())));
    };
    if version != 2 {
        return Err(wrong(format!("it has version {version}; expected 2")));
    }
    let length = usize::try_from(length).unwrap_or(usize::MAX);
    let Some(mut rest) = bytes.get(HEADER_BYTES..length) else {
        return Err(wrong(format!("its header says {length} bytes, but there are {}", bytes.len())));
    };
    let mut json = None;
    let mut bin = None;
    let mut index = 0_usize;
    while !rest.is_empty() {
        let (Some(size), Some(kind)) =
            (rest.first_chunk::<4>(), rest.get(4..CHUNK_HEADER_BYTES).and_then(|k| k.first_chunk::<4>()))
        else {
            return Err(wrong(format!("it ends within the header of chunk {index}")));
        };
        let size = usize::try_from(u32::from_le_bytes(*size)).unwrap_or(usize::MAX);
        let body = rest.get(CHUNK_HEADER_BYTES..).unwrap_or_default();
        let Some(data) = body.get(..size) else {
            return Err(wrong(format!("chunk {index} says {size} bytes, but {} are left", body.len())));
        };
        match (index, u32::from_le_bytes(*kind)) {
            (0, JSON_CHUNK) => json = Some(data),
            (0, _) => return Err(wrong("its first chunk is not JSON".into())),
            (1, BIN_CHUNK) => bin = Some(data),
            // The specification requires readers to skip later and unknown chunks.
            _ => {}
        }
        rest = body.get(size..).unwrap_or_default();
        index += 1;
    }
    match json {
        Some(json) => Ok((json, bin)),
        None => Err(wrong("it has no chunks; the first must be JSON".into())),
    }
}

fn parse_json(json: &[u8], budget: &Budget) -> Result<Root, LoadError> {
    let text = std::str::from_utf8(json)
        .map_err(|e| LoadError::Container(format!("this is neither a GLB nor UTF-8 text: byte {}", e.valid_up_to())))?;
    // Neither a byte order mark nor zeros as a chunk's padding are allowed, but both occur.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim_end_matches('\0');
    if text.trim_start().is_empty() {
        return Err(LoadError::Container("the file is empty; expected glTF JSON or a GLB".into()));
    }
    if !text.trim_start().starts_with('{') {
        return Err(LoadError::Container("this is neither a GLB nor glTF JSON, which starts with `{`".into()));
    }
    budget.take(structure_bytes(text), "the file's JSON")?;
    let (root, text) = match read_root(text) {
        Ok(root) => (root, Cow::Borrowed(text)),
        Err(_) => read_repaired(text, budget)?,
    };
    let mut deserializer = serde_json::Deserializer::from_str(&text);
    WideIndices { key: "" }.deserialize(&mut deserializer).map_err(|error| LoadError::Json(error.to_string()))?;
    Ok(root)
}

/// A lower bound for the parsed size of a file's objects.
fn structure_bytes(text: &str) -> u64 {
    let largest = size_of::<Material>().max(size_of::<Node>()).max(size_of::<Primitive>()).max(size_of::<Accessor>());
    text.bytes().filter(|&byte| byte == b'{').count() as u64 * largest as u64
}

/// Reads valid JSON that `gltf-json` rejects.
fn read_repaired<'a>(text: &'a str, budget: &Budget) -> Result<(Root, Cow<'a, str>), LoadError> {
    let bytes = text.len() as u64;
    budget.take(2 * bytes, "the file's JSON")?;
    let text = repair::whole_numbers(text);
    match read_root(&text) {
        Ok(root) => Ok((root, text)),
        Err(LoadError::Json(error)) if ["scenes[", "animations["].iter().any(|list| error.starts_with(list)) => {
            let text = repair::scenes_and_animations(&text).ok_or(LoadError::Json(error))?;
            Ok((read_root(&text)?, Cow::Owned(text)))
        }
        Err(error) => Err(error),
    }
}

fn read_root(text: &str) -> Result<Root, LoadError> {
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let root = Root::deserialize(&mut deserializer).map_err(|error| {
        let path = path_of(text, &error);
        LoadError::Json(if path.is_empty() { error.to_string() } else { format!("{path}: {error}") })
    })?;
    deserializer.end().map_err(|error| LoadError::Json(error.to_string()))?;
    Ok(root)
}

/// Keys whose integers the `gltf` crate truncates to 32 bits, so that 4294967296 would be read as 0.
const INDEX_KEYS: [&str; 18] = [
    "scene",
    "nodes",
    "children",
    "mesh",
    "skin",
    "camera",
    "light",
    "buffer",
    "bufferView",
    "material",
    "indices",
    "attributes",
    "targets",
    "joints",
    "inverseBindMatrices",
    "source",
    "sampler",
    "index",
];
/// Keys of enumerations, truncated the same way.
const ENUM_KEYS: [&str; 7] = ["componentType", "mode", "magFilter", "minFilter", "wrapS", "wrapT", "target"];

/// Walks over JSON and rejects such integers beyond 32 bits. `key` is the nearest of these keys above the value.
#[derive(Clone, Copy)]
struct WideIndices {
    key: &'static str,
}

impl<'de> DeserializeSeed<'de> for WideIndices {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for WideIndices {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<(), E> {
        if !self.key.is_empty() && value > u64::from(u32::MAX) {
            return Err(E::custom(format_args!("{value} under \"{}\" is more than 32 bits hold", self.key)));
        }
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        while seq.next_element_seed(self)?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            // Application data may contain any number.
            if key == "extras" {
                map.next_value::<IgnoredAny>()?;
                continue;
            }
            let own = INDEX_KEYS.iter().chain(&ENUM_KEYS).find(|k| **k == key).copied();
            // "attributes" and "targets" contain indices under arbitrary names; other keys apply only to their direct
            // values.
            let inherited = if matches!(self.key, "attributes" | "targets") { self.key } else { "" };
            map.next_value_seed(Self { key: own.unwrap_or(inherited) })?;
        }
        Ok(())
    }
}
