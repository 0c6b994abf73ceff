//! The bytes that the JSON refers to: the BIN chunk, data URIs and external files.

use super::budget::Budget;
use super::json::{Buffer, Int, Meshopt, Property, Root};
use super::{FileError, LoadError, Resolver, at, meshopt};
use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
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
    root: &'a Root<'a>,
    bin: Option<&'a [u8]>,
    resolver: &'a dyn Resolver,
    budget: &'a Budget,
    /// Each buffer's bytes, or why there are none.
    read: Vec<OnceCell<Result<Cow<'a, [u8]>, LoadError>>>,
    /// The bytes of views that are compressed.
    decoded: Vec<OnceCell<Result<Vec<u8>, LoadError>>>,
}

/// A part of a buffer: of a view, or of what a compressed view is made from.
struct Part<'a> {
    buffer: &'a Property<Int>,
    offset: &'a Property<Int>,
    length: &'a Property<Int>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        root: &'a Root<'a>,
        bin: Option<&'a [u8]>,
        resolver: &'a dyn Resolver,
        budget: &'a Budget,
    ) -> Result<Self, LoadError> {
        let (buffers, views) = (root.buffers.elements().len(), root.buffer_views.elements().len());
        let mut read = budget.vec(buffers as u64, "buffers")?;
        read.resize_with(buffers, OnceCell::new);
        let mut decoded = budget.vec(views as u64, "bufferViews")?;
        decoded.resize_with(views, OnceCell::new);
        Ok(Self { root, bin, resolver, budget, read, decoded })
    }

    /// The bytes of a buffer, which may be fewer or more than its byteLength.
    fn buffer(&self, index: Int, path: &str) -> Result<(&Buffer<'a>, &[u8]), LoadError> {
        let buffer = self.root.buffers.at(index, path, ("buffers", "buffer"))?;
        let Some(cell) = self.read.get(index.index()) else { return Ok((buffer, &[])) };
        match cell.get_or_init(|| self.read(index, buffer)) {
            Ok(bytes) => Ok((buffer, bytes)),
            Err(error) => Err(error.clone()),
        }
    }

    fn read(&self, index: Int, buffer: &Buffer<'a>) -> Result<Cow<'a, [u8]>, LoadError> {
        let path = format!("buffers[{index}]");
        match (buffer.uri.get(|| format!("{path}.uri"))?, self.bin) {
            (Some(uri), _) => match read_uri(&uri.0, &format!("{path}.uri"), self.resolver, self.budget) {
                Ok(bytes) => Ok(Cow::Owned(bytes)),
                Err(LoadError::Invalid { path, problem }) => Err(LoadError::Buffer { path, problem }),
                Err(error) => Err(error),
            },
            (None, Some(bin)) if index.0 == 0 => Ok(Cow::Borrowed(bin)),
            (None, _) => {
                let problem = "has no uri, which only buffers[0] of a GLB with a BIN chunk may omit".into();
                Err(LoadError::Buffer { path, problem })
            }
        }
    }

    /// The bytes of a buffer view and its stride.
    pub(super) fn view(&self, index: Int, path: &str) -> Result<(&[u8], Option<usize>), LoadError> {
        let view = self.root.buffer_views.at(index, path, ("bufferViews", "bufferView"))?;
        let path = format!("bufferViews[{index}]");
        let stride = view.byte_stride.get(|| format!("{path}.byteStride"))?.map(|stride| stride.index());
        let plain = Part { buffer: &view.buffer, offset: &view.byte_offset, length: &view.byte_length };
        let extensions = view.extensions.get(|| format!("{path}.extensions"))?;
        let Some(extensions) = extensions else { return Ok((self.part(&plain, &path)?, stride)) };
        let (khr, ext) = (&extensions.khr, &extensions.ext);
        let names = [(khr, "KHR_meshopt_compression"), (ext, "EXT_meshopt_compression")];
        for (property, name) in names {
            let path = format!("{path}.extensions.{name}");
            let Some(meshopt) = property.get(|| path.clone())? else { continue };
            let Some(cell) = self.decoded.get(index.index()) else { continue };
            match cell.get_or_init(|| self.decode(meshopt, &path)) {
                Ok(bytes) => return Ok((bytes, stride.or(meshopt.byte_stride.ok().map(|stride| stride.index())))),
                // What the compressed bytes replace may be there as well.
                Err(error) => return self.part(&plain, &path).map(|bytes| (bytes, stride)).map_err(|_| error.clone()),
            }
        }
        Ok((self.part(&plain, &path)?, stride))
    }

    /// Decompresses what takes the place of a view.
    fn decode(&self, meshopt: &Meshopt, path: &str) -> Result<Vec<u8>, LoadError> {
        let part = Part { buffer: &meshopt.buffer, offset: &meshopt.byte_offset, length: &meshopt.byte_length };
        let bytes = self.part(&part, path)?;
        meshopt::decode(meshopt, bytes, self.budget, path)
    }

    /// The bytes of a part of a buffer, which is at `path`.
    fn part(&self, part: &Part<'_>, path: &str) -> Result<&[u8], LoadError> {
        let index = *part.buffer.need(|| format!("{path}.buffer"))?;
        let (buffer, bytes) = self.buffer(index, &format!("{path}.buffer"))?;
        let offset = part.offset.get(|| format!("{path}.byteOffset"))?.map_or(0, |offset| offset.0);
        let length = part.length.need(|| format!("{path}.byteLength"))?.0;
        let end = offset.saturating_add(length);
        // More is allowed: a BIN chunk is padded, and a file may be shared.
        let most = buffer.byte_length.ok().map_or(bytes.len() as u64, |most| most.0);
        let range = usize::try_from(offset).ok().zip(usize::try_from(end).ok());
        match range.and_then(|(offset, end)| bytes.get(offset..end)) {
            Some(bytes) if end <= most => Ok(bytes),
            None if end <= most => {
                let problem = format!("has {} bytes, fewer than its byteLength of {most}", bytes.len());
                Err(LoadError::Buffer { path: format!("buffers[{index}]"), problem })
            }
            _ => {
                let problem = format!(
                    "byteOffset {offset} + byteLength {length} is more than the {most} bytes of buffers[{index}]"
                );
                Err(at(path, problem))
            }
        }
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
        let read = read_file(&file, resolver, budget);
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

/// The bytes of a file. Writers on Windows separate folders by backslashes, which glTF forbids; they are read as slashes
/// where no file has the literal name.
fn read_file(file: &str, resolver: &dyn Resolver, budget: &Budget) -> Result<Vec<u8>, FileError> {
    match resolver.read(file, budget.left()) {
        Err(FileError::Unreadable(problem)) if file.contains('\\') => {
            let read = resolver.read(&file.replace('\\', "/"), budget.left());
            read.map_err(|error| match error {
                FileError::Unreadable(_) => FileError::Unreadable(problem),
                error => error,
            })
        }
        read => read,
    }
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
