//! The bytes that the JSON refers to: the BIN chunk, data URIs and external files.

use super::budget::Budget;
use super::{FileError, LoadError, Resolver, at, check};
use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::{Buffer, Index, Root, buffer::View};
use std::borrow::Cow;
use std::cell::OnceCell;

/// Base64 with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The buffers of a file, each read when first needed: those that are never needed may be missing.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    bin: Option<&'a [u8]>,
    resolver: &'a dyn Resolver,
    budget: &'a Budget,
    /// Each buffer's bytes, truncated to its `byteLength`.
    read: Vec<OnceCell<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        root: &'a Root,
        bin: Option<&'a [u8]>,
        resolver: &'a dyn Resolver,
        budget: &'a Budget,
    ) -> Result<Self, LoadError> {
        let mut read = budget.vec(root.buffers.len() as u64, "buffers")?;
        read.resize_with(root.buffers.len(), OnceCell::new);
        Ok(Self { root, bin, resolver, budget, read })
    }

    /// The bytes of buffer `i`, which `path` refers to.
    fn buffer(&self, index: Index<Buffer>, path: &str) -> Result<&[u8], LoadError> {
        let cell = check::get(&self.read, index, path, "buffer")?;
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let bytes = self.read(index)?;
        Ok(cell.get_or_init(|| bytes))
    }

    fn read(&self, index: Index<Buffer>) -> Result<Cow<'a, [u8]>, LoadError> {
        let path = format!("buffers[{index}]");
        let buffer = check::get(&self.root.buffers, index, &path, "buffer")?;
        let length = buffer.byte_length.0;
        let bytes = match (&buffer.uri, self.bin) {
            (Some(uri), _) => Cow::Owned(read_uri(uri, &format!("{path}.uri"), self.resolver, self.budget)?),
            (None, Some(bin)) if index.value() == 0 => Cow::Borrowed(bin),
            (None, _) => {
                let problem = "has no uri, which only buffers[0] of a GLB with a BIN chunk may omit";
                return Err(at(path, problem));
            }
        };
        // More is allowed: a BIN chunk is padded, and a file may be shared.
        let cut = usize::try_from(length).ok().filter(|&length| length <= bytes.len());
        let Some(cut) = cut else {
            return Err(at(path, format!("has {} bytes, fewer than its byteLength of {length}", bytes.len())));
        };
        Ok(match bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(bytes.get(..cut).unwrap_or_default()),
            Cow::Owned(mut bytes) => {
                bytes.truncate(cut);
                Cow::Owned(bytes)
            }
        })
    }

    /// The bytes of a buffer view and its stride.
    pub(super) fn view(&self, index: Index<View>, path: &str) -> Result<(&[u8], Option<usize>), LoadError> {
        let view = check::get(&self.root.buffer_views, index, path, "bufferView")?;
        let path = format!("bufferViews[{index}]");
        let buffer = self.buffer(view.buffer, &format!("{path}.buffer"))?;
        let (offset, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
        let range =
            offset.checked_add(length).and_then(|end| Some(usize::try_from(offset).ok()?..usize::try_from(end).ok()?));
        match range.and_then(|range| buffer.get(range)) {
            Some(bytes) => Ok((bytes, view.byte_stride.map(|stride| stride.0))),
            None => {
                let problem = format!(
                    "byteOffset {offset} + byteLength {length} is more than the {} bytes of buffers[{}]",
                    buffer.len(),
                    view.buffer
                );
                Err(at(path, problem))
            }
        }
    }

    /// The size of all buffers together. Reads every buffer that can be read.
    pub(super) fn total_bytes(&self) -> u64 {
        let buffers = (0..self.read.len() as u32).map(|i| self.buffer(Index::new(i), ""));
        buffers.map(|bytes| bytes.map_or(0, |bytes| bytes.len() as u64)).sum()
    }
}

/// The bytes of a URI: those in a data URI, or from the resolver.
pub(super) fn read_uri(uri: &str, path: &str, resolver: &dyn Resolver, budget: &Budget) -> Result<Vec<u8>, LoadError> {
    if is_data(uri) {
        return read_data_uri(uri.get(5..).unwrap_or_default(), path, budget);
    }
    const ABSOLUTE: &str = "is an absolute path; expected one relative to the glTF file";
    let scheme = scheme(uri);
    // A scheme of one letter is a drive.
    if is_absolute(uri) || scheme.is_some_and(|scheme| scheme.len() == 1) {
        return Err(at(path, ABSOLUTE));
    }
    if let Some(scheme) = scheme {
        return Err(at(path, format!("is a {scheme}: URI; expected a data: URI or a relative path")));
    }
    let Ok(file) = percent_encoding::percent_decode_str(uri).decode_utf8() else {
        return Err(at(path, "is not UTF-8 once its percent signs are decoded"));
    };
    let problem = if file.is_empty() {
        "is empty; expected a relative path or a data: URI"
    } else if is_absolute(&file) {
        ABSOLUTE
    } else if file.contains('\0') {
        "has a zero byte in its file name"
    } else {
        let read = resolver.read(&file, budget.left());
        let bytes = read.map_err(|error| match error {
            FileError::Outside { folder } => LoadError::Outside { path: path.into(), uri: uri.into(), folder },
            FileError::TooLarge { bytes } => {
                budget.take(bytes, path).err().unwrap_or_else(|| at(path, error.to_string()))
            }
            FileError::Unreadable(problem) => LoadError::External { path: path.into(), file: file.into(), problem },
        })?;
        budget.take(bytes.len() as u64, path)?;
        return Ok(bytes);
    };
    Err(at(path, problem))
}

/// Whether a URI holds the bytes itself.
pub(super) fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// Whether a path starts at a root or a drive, of this system or another.
fn is_absolute(path: &str) -> bool {
    let drive = |path: &[u8]| matches!(path, [letter, b':', b'/' | b'\\', ..] if letter.is_ascii_alphabetic());
    path.starts_with(['/', '\\']) || drive(path.as_bytes())
}

/// The part before `:` if it has the form of a scheme.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut chars = scheme.chars();
    let starts = chars.next()?.is_ascii_alphabetic();
    (starts && chars.all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))).then_some(scheme)
}

/// `[<media type>][;base64],<data>`.
fn read_data_uri(rest: &str, path: &str, budget: &Budget) -> Result<Vec<u8>, LoadError> {
    let Some((media_type, data)) = rest.split_once(',') else {
        return Err(at(path, "is a data: URI without the comma before its data"));
    };
    let is_base64 = media_type.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    let plain = if data.contains('%') || !is_base64 {
        let mut plain = budget.vec::<u8>(data.len() as u64, path)?;
        plain.extend(percent_encoding::percent_decode_str(data));
        Cow::Owned(plain)
    } else {
        Cow::Borrowed(data.as_bytes())
    };
    if !is_base64 {
        return Ok(plain.into_owned());
    }
    let most = base64::decoded_len_estimate(plain.len());
    let mut out = budget.vec::<u8>(most as u64, path)?;
    out.resize(most, 0);
    let wrong = |error: base64::DecodeSliceError| at(path, format!("is not valid base64: {error}"));
    let length = BASE64.decode_slice(&plain, &mut out).map_err(wrong)?;
    out.truncate(length);
    Ok(out)
}
