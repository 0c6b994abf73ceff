//! The bytes that the JSON refers to: the BIN chunk, data URIs and external files.

use super::budget::Budget;
use super::{LoadError, Resolver, at, check};
use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::{Index, Root, buffer::View};
use std::borrow::Cow;

/// Base64 as it is met: with or without its padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Every buffer's bytes, cut to its `byteLength`.
pub(super) struct Buffers<'a>(Vec<Cow<'a, [u8]>>);

/// Reads all buffers of a file.
pub(super) fn gather<'a>(
    root: &Root,
    bin: Option<&'a [u8]>,
    resolver: &dyn Resolver,
    budget: &Budget,
) -> Result<Buffers<'a>, LoadError> {
    let mut all = Vec::with_capacity(root.buffers.len());
    for (i, buffer) in root.buffers.iter().enumerate() {
        let path = format!("buffers[{i}]");
        let length = buffer.byte_length.0;
        let bytes = match (&buffer.uri, bin) {
            (Some(uri), _) => Cow::Owned(read_uri(uri, &format!("{path}.uri"), resolver, budget)?),
            (None, Some(bin)) if i == 0 => Cow::Borrowed(bin),
            (None, _) => {
                let problem = "has no uri, and only buffers[0] of a GLB with a BIN chunk may do without";
                return Err(at(path, problem));
            }
        };
        // More is allowed: a BIN chunk is padded, and a file may be shared.
        let cut = usize::try_from(length).ok().filter(|&length| length <= bytes.len());
        let Some(cut) = cut else {
            return Err(at(path, format!("has {} bytes, fewer than its byteLength of {length}", bytes.len())));
        };
        all.push(match bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(bytes.get(..cut).unwrap_or_default()),
            Cow::Owned(mut bytes) => {
                bytes.truncate(cut);
                Cow::Owned(bytes)
            }
        });
    }
    Ok(Buffers(all))
}

impl Buffers<'_> {
    /// The bytes of a buffer view and its stride.
    pub(super) fn view(
        &self,
        root: &Root,
        index: Index<View>,
        path: &str,
    ) -> Result<(&[u8], Option<usize>), LoadError> {
        let view = check::get(&root.buffer_views, index, path, "bufferView")?;
        let path = format!("bufferViews[{index}]");
        let buffer = check::get(&self.0, view.buffer, &format!("{path}.buffer"), "buffer")?;
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

    /// The bytes of all buffers together.
    pub(super) fn total_bytes(&self) -> u64 {
        self.0.iter().map(|bytes| bytes.len() as u64).sum()
    }
}

/// The bytes that a URI stands for: those within a data URI, or the resolver's.
pub(super) fn read_uri(uri: &str, path: &str, resolver: &dyn Resolver, budget: &Budget) -> Result<Vec<u8>, LoadError> {
    if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        return read_data_uri(uri.get(5..).unwrap_or_default(), path, budget);
    }
    if let Some(scheme) = scheme(uri) {
        return Err(at(path, format!("is a {scheme}: URI; a data: URI or a relative path is what raystep reads")));
    }
    let Ok(file) = percent_encoding::percent_decode_str(uri).decode_utf8() else {
        return Err(at(path, "is not UTF-8 once its percent signs are decoded"));
    };
    let problem = if file.is_empty() {
        "is empty; a relative path or a data: URI would be right"
    } else if file.starts_with(['/', '\\']) {
        "is an absolute path; one relative to the glTF file would be right"
    } else if file.contains('\0') {
        "has a zero byte in its file name"
    } else {
        let read = resolver.read(&file, budget.left());
        let bytes = read.map_err(|problem| LoadError::External { path: path.into(), file: file.into(), problem })?;
        budget.take(bytes.len() as u64, path)?;
        return Ok(bytes);
    };
    Err(at(path, problem))
}

/// The part before `:` where it has the form of a scheme.
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
    budget.take(if is_base64 { data.len() as u64 / 4 * 3 } else { data.len() as u64 }, path)?;
    let decoded: Cow<'_, [u8]> = if data.contains('%') {
        percent_encoding::percent_decode_str(data).into()
    } else {
        Cow::Borrowed(data.as_bytes())
    };
    if is_base64 {
        BASE64.decode(&decoded).map_err(|error| at(path, format!("is not valid base64: {error}")))
    } else {
        Ok(decoded.into_owned())
    }
}
