//! Splits the file's bytes into its JSON and its BIN chunk.

use super::budget::Budget;
use super::json::{self, Accessor, Material, Node, Root};
use super::{LoadError, at};

const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BIN_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// The parsed JSON and, if a GLB has one, the BIN chunk.
pub(super) fn parse<'a>(bytes: &'a [u8], budget: &Budget) -> Result<(Root<'a>, Option<&'a [u8]>), LoadError> {
    let (json, bin) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let root = parse_json(json, budget)?;
    check_version(&root)?;
    Ok((root, bin))
}

/// Rejects files of other versions. Without a minVersion, every 2.x file can be read as 2.0; one with meshes that does
/// not say its version is read, too.
fn check_version(root: &Root<'_>) -> Result<(), LoadError> {
    let asset = root.asset.ok();
    match asset.and_then(|asset| asset.min_version.ok()) {
        Some(needed) if needed != "2.0" => {
            let problem = format!("is {needed:?}, which raystep cannot read; it reads 2.0");
            return Err(at("asset.minVersion", problem));
        }
        Some(_) => return Ok(()),
        None => {}
    }
    match asset.and_then(|asset| asset.version.ok()) {
        Some(version) if version.starts_with("2.") => Ok(()),
        Some(version) => Err(at("asset", format!("is of glTF version {version:?}; expected 2.0"))),
        None if root.meshes.elements().is_empty() => {
            root.asset.need(|| "asset".to_owned())?.version.need(|| "asset.version".to_owned()).map(drop)
        }
        None => Ok(()),
    }
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

fn parse_json<'a>(json: &'a [u8], budget: &Budget) -> Result<Root<'a>, LoadError> {
    let wrong = |problem: String| Err(LoadError::Container(problem));
    let text = match std::str::from_utf8(json) {
        Ok(text) => text,
        Err(e) => return wrong(format!("the JSON is not UTF-8 text: byte {}", e.valid_up_to())),
    };
    // Neither a byte order mark nor zeros as a chunk's padding are allowed, but both occur.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim_end_matches('\0');
    if !text.trim_start().starts_with('{') {
        return wrong("the GLB's JSON does not start with `{`".into());
    }
    budget.take(structure_bytes(text), "the file's JSON")?;
    json::read(text)
}

/// An upper bound for the parsed size of a file's objects and lists.
fn structure_bytes(text: &str) -> u64 {
    let largest = size_of::<Node<'_>>().max(size_of::<Accessor>()).max(size_of::<Material<'_>>());
    // An element of a list after its first, a name in a map, or what is wrong with either.
    const ELEMENT: usize = 96;
    let bytes = text.bytes().map(|byte| match byte {
        b'{' => largest as u64,
        b',' => ELEMENT as u64,
        _ => 0,
    });
    bytes.sum()
}
