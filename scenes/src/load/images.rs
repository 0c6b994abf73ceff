//! Decodes PNG, JPEG and WebP images into texels, within limits.
//!
//! An image that could not be traced or exceeds the budget is rejected by its header, before anything is decoded. Each
//! image is then decoded into the memory in which its texels stay, PNGs row by row, others packed at its end, so that
//! there is no second copy of theirs.

use super::budget::{Budget, reserve};
use super::buffers::{Buffers, read_uri};
use super::json::Image;
use super::{LoadError, Resolver, at};
use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder as _, ImageFormat, Limits};
use image_webp::WebPDecoder;
use png::{BitDepth, Transformations};
use std::borrow::Cow;
use std::cell::Cell;
use std::io::Cursor;

/// Maximum width and height; no known adapter has larger textures.
const MAX_SIDE: u32 = 32_768;
/// Bytes of a texel here, plus those of the kernels' copy: linear, 16 bits per channel.
const TEXEL_BYTES: u64 = 4 + 8;
/// Maximum size of a PNG's chunks other than its image.
const CHUNK_BYTES: usize = 16 << 20;

/// Texels and size of an image.
pub(super) struct Texels {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: Vec<[u8; 4]>,
}

/// The source of images, and their limits.
pub(super) struct Images<'a> {
    pub(super) buffers: &'a Buffers<'a>,
    pub(super) resolver: &'a dyn Resolver,
    pub(super) budget: &'a Budget,
    /// See [`LoadOptions::max_texels`](super::LoadOptions::max_texels).
    pub(super) max_texels: u64,
    /// Texels so far.
    pub(super) texels: Cell<u64>,
}

impl Images<'_> {
    /// Decodes `images[index]`.
    pub(super) fn read(&self, index: usize, image: &Image<'_>) -> Result<Texels, LoadError> {
        let path = format!("images[{index}]");
        let uri = image.uri.get(|| format!("{path}.uri"))?;
        let view = image.buffer_view.get(|| format!("{path}.bufferView"))?;
        let bytes = match (uri, view) {
            (Some(uri), None) => Cow::Owned(read_uri(&uri.0, &format!("{path}.uri"), self.resolver, self.budget)?),
            (None, Some(view)) => Cow::Borrowed(self.buffers.view(*view, &format!("{path}.bufferView"))?.0),
            (Some(_), Some(_)) => return Err(at(path, "has both a uri and a bufferView; one of them would be right")),
            (None, None) => return Err(at(path, "has neither a uri nor a bufferView")),
        };
        // The bytes identify the format more reliably than mimeType, which exporters get wrong.
        match image::guess_format(&bytes) {
            Ok(ImageFormat::Png) => self.read_png(&bytes, &path),
            Ok(ImageFormat::Jpeg) => self.read_jpeg(&bytes, &path),
            Ok(ImageFormat::WebP) => self.read_webp(&bytes, &path),
            _ if bytes.starts_with(b"\xabKTX 20\xbb") => {
                Err(at(path, "is a KTX2 texture (KHR_texture_basisu), which raystep does not read"))
            }
            _ => Err(at(path, "is neither a PNG, a JPEG nor a WebP image")),
        }
    }

    /// Charges and reserves memory for an image of this size, or returns why not. Nothing is decoded yet.
    fn room(&self, width: u32, height: u32, path: &str) -> Result<Texels, LoadError> {
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(at(path, format!("is {width} x {height} texels; 1 to {MAX_SIDE} a side would be right")));
        }
        let count = u64::from(width) * u64::from(height);
        let all = self.texels.get() + count;
        if all > self.max_texels {
            let limit = self.max_texels;
            return Err(LoadError::TooManyTexels { path: path.to_owned(), width, height, all, limit });
        }
        self.budget.take(count * TEXEL_BYTES, path)?;
        self.texels.set(all);
        Ok(Texels { width, height, texels: reserve(count, path)? })
    }

    fn read_png(&self, bytes: &[u8], path: &str) -> Result<Texels, LoadError> {
        let wrong = |error: png::DecodingError| cannot(path, &error);
        let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: CHUNK_BYTES });
        // Neither is used, and both may be long.
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        decoder.set_transformations(Transformations::EXPAND);
        let header = decoder.read_header_info().map_err(wrong)?;
        let mut out = self.room(header.width, header.height, path)?;
        let mut reader = decoder.read_info().map_err(wrong)?;
        let (channels, depth) = reader.output_color_type();
        let to_rgba = Packed { channels: channels.samples(), deep: depth == BitDepth::Sixteen };
        // A row of the image, or the part of it in one interlaced pass.
        let line_bytes = reader.output_line_size(out.width).unwrap_or(usize::MAX);
        let mut line = reserve::<u8>(line_bytes as u64, path)?;
        line.resize(line_bytes, 0);
        let mut row = reserve::<[u8; 4]>(out.width.into(), path)?;
        let texels = out.width as usize * out.height as usize;
        while let Some(place) = reader.read_row(&mut line).map_err(wrong)? {
            match place {
                png::InterlaceInfo::Null(_) => {
                    let left = texels - out.texels.len();
                    out.texels.extend(to_rgba.texels(&line).take(left.min(out.width as usize)));
                }
                png::InterlaceInfo::Adam7(pass) => {
                    out.texels.resize(texels, [0; 4]);
                    row.clear();
                    row.extend(to_rgba.texels(&line));
                    let stride = 4 * out.width as usize;
                    png::expand_interlaced_row(out.texels.as_flattened_mut(), stride, row.as_flattened(), &pass, 32);
                }
            }
        }
        if out.texels.len() == texels { Ok(out) } else { Err(at(path, "ends before its last row")) }
    }

    fn read_jpeg(&self, bytes: &[u8], path: &str) -> Result<Texels, LoadError> {
        let wrong = |error: image::ImageError| cannot(path, &error);
        let input_bytes = bytes.len() as u64;
        // The decoder keeps a copy of its input.
        self.budget.hold(input_bytes, path, || {
            drop(reserve::<u8>(input_bytes, path)?);
            let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(wrong)?;
            let (width, height) = decoder.dimensions();
            let mut out = self.room(width, height, path)?;
            let is_gray = decoder.color_type() == ColorType::L8;
            let coefficients = coefficient_bytes(bytes, width, height, is_gray);
            self.budget.hold(coefficients, path, || {
                let mut limits = Limits::no_limits();
                (limits.max_image_width, limits.max_image_height) = (Some(width), Some(height));
                decoder.set_limits(limits).map_err(wrong)?;
                // The decoder has no error for lack of memory, so its allocation is tried first.
                drop(reserve::<u8>(coefficients, path)?);
                let channels = decoder.color_type().channel_count().into();
                read_packed(&mut out, channels, |packed| decoder.read_image(packed)).map_err(wrong)?;
                Ok(out)
            })
        })
    }

    fn read_webp(&self, bytes: &[u8], path: &str) -> Result<Texels, LoadError> {
        let wrong = |error: image_webp::DecodingError| cannot(path, &error);
        let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(wrong)?;
        if decoder.is_animated() {
            return Err(at(path, "is an animated WebP, which no texture may be"));
        }
        let (width, height) = decoder.dimensions();
        let mut out = self.room(width, height, path)?;
        self.budget.hold(webp_bytes(bytes, width, height), path, || {
            let channels = if decoder.has_alpha() { 4 } else { 3 };
            read_packed(&mut out, channels, |packed| decoder.read_image(packed)).map_err(wrong)?;
            Ok(out)
        })
    }
}

/// Decodes an image of so many 8-bit channels into its texels.
fn read_packed<E>(out: &mut Texels, channels: usize, read: impl FnOnce(&mut [u8]) -> Result<(), E>) -> Result<(), E> {
    out.texels.resize(out.width as usize * out.height as usize, [0; 4]);
    let all = out.texels.as_flattened_mut();
    let packed = all.len() / 4 * (4 - channels);
    read(all.get_mut(packed..).unwrap_or_default())?;
    spread(all, channels);
    Ok(())
}

/// The decoder's message in one line.
fn cannot(path: &str, error: &dyn std::fmt::Display) -> LoadError {
    let words = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    at(path, format!("cannot be decoded: {words}"))
}

/// Maximum number of bytes that the decoder of a JPEG needs besides its image: all coefficients, 16 bits each, if the
/// image has several scans. Markers may also occur in a thumbnail's bytes; then this is more than needed.
fn coefficient_bytes(bytes: &[u8], width: u32, height: u32, is_gray: bool) -> u64 {
    let count = |marker: u8| bytes.windows(2).filter(|pair| *pair == [0xff, marker]).count();
    let (progressive, start_of_scan) = (0xc2, 0xda);
    if count(progressive) == 0 && count(start_of_scan) < 2 {
        return 0;
    }
    // Blocks of the largest size that the format allows, in up to four components.
    let side = |texels: u32| u64::from(texels).next_multiple_of(32);
    side(width) * side(height) * 2 * if is_gray { 1 } else { 4 }
}

/// Maximum number of bytes that the decoder of a WebP needs besides its image: planes of colours and alpha, and in
/// lossless parts, tables of up to 65,536 codes for each of five kinds of values.
fn webp_bytes(bytes: &[u8], width: u32, height: u32) -> u64 {
    const PER_TEXEL: u64 = 12;
    /// A table of 1,024 entries takes at least eight bytes of the file.
    const TABLES_PER_BYTE: u64 = 512;
    const MOST_TABLES: u64 = (5 << 16) * 4500;
    let has_tables = bytes.windows(4).any(|name| name == b"VP8L" || name == b"ALPH");
    let tables = if has_tables { (bytes.len() as u64 * TABLES_PER_BYTE).min(MOST_TABLES) } else { 0 };
    u64::from(width) * u64::from(height) * PER_TEXEL + tables
}

/// Layout of a PNG's texels once palette, transparent colour and low bit depths are expanded.
#[derive(Clone, Copy)]
struct Packed {
    channels: usize,
    /// Whether channels have two bytes, the high one first.
    deep: bool,
}

impl Packed {
    fn texels(self, line: &[u8]) -> impl Iterator<Item = [u8; 4]> {
        let Self { channels, deep } = self;
        line.chunks_exact(channels * if deep { 2 } else { 1 }).map(move |texel| {
            let channel = |i: usize| {
                if !deep {
                    return texel.get(i).copied().unwrap_or_default();
                }
                let value = texel.get(2 * i..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default();
                // Rounded to 8 bits.
                ((u32::from(u16::from_be_bytes(value)) + 128) / 257) as u8
            };
            match channels {
                1 => [channel(0), channel(0), channel(0), 255],
                2 => [channel(0), channel(0), channel(0), channel(1)],
                3 => [channel(0), channel(1), channel(2), 255],
                _ => [channel(0), channel(1), channel(2), channel(3)],
            }
        })
    }
}

/// Expands texels of `channels` bytes each at the end of `all` to texels of four bytes that fill it. Writing never
/// overtakes reading.
fn spread(all: &mut [u8], channels: usize) {
    let texels = all.len() / 4;
    let packed = texels * (4 - channels);
    let to_rgba = Packed { channels, deep: false };
    for i in 0..texels {
        let from = packed + channels * i;
        let texel = all.get(from..from + channels).and_then(|bytes| to_rgba.texels(bytes).next());
        if let (Some(texel), Some(to)) = (texel, all.get_mut(4 * i..4 * i + 4)) {
            to.copy_from_slice(&texel);
        }
    }
}
