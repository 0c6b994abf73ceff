//! PNG and JPEG images into texels, within limits.

use super::budget::Budget;
use super::buffers::{Buffers, read_uri};
use super::{LoadError, Resolver, at};
use gltf::json::{Image, Root};
use image::{ImageFormat, ImageReader, Limits};
use std::borrow::Cow;
use std::io::Cursor;

/// The most texels a side; more than any adapter's texture, and 4 GiB of texels at most.
const MAX_SIDE: u32 = 32_768;

/// Texels and size of an image.
pub(super) struct Texels {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: Vec<[u8; 4]>,
}

/// Decodes `images[index]`.
pub(super) fn read(
    root: &Root,
    index: usize,
    image: &Image,
    buffers: &Buffers<'_>,
    resolver: &dyn Resolver,
    budget: &Budget,
) -> Result<Texels, LoadError> {
    let path = format!("images[{index}]");
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), None) => Cow::Owned(read_uri(uri, &format!("{path}.uri"), resolver, budget)?),
        (None, Some(view)) => Cow::Borrowed(buffers.view(root, view, &format!("{path}.bufferView"))?.0),
        (Some(_), Some(_)) => return Err(at(path, "has both a uri and a bufferView; one of them would be right")),
        (None, None) => return Err(at(path, "has neither a uri nor a bufferView")),
    };
    decode(&bytes, &path, budget)
}

fn decode(bytes: &[u8], path: &str, budget: &Budget) -> Result<Texels, LoadError> {
    // The bytes tell the format better than mimeType, which exporters get wrong.
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
        _ => return Err(at(path, "is neither a PNG nor a JPEG")),
    };
    let wrong = |error: image::ImageError| at(path, format!("cannot be decoded: {error}"));
    let dimensions = ImageReader::with_format(Cursor::new(bytes), format).into_dimensions();
    let (width, height) = dimensions.map_err(wrong)?;
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(at(path, format!("is {width} x {height} texels; 1 to {MAX_SIDE} a side would be right")));
    }
    // Decoded as up to four 16-bit channels, then as 8-bit ones, then as texels.
    let texel_count = u64::from(width) * u64::from(height);
    budget.take(texel_count * (8 + 4 + 4), path)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(width);
    limits.max_image_height = Some(height);
    // The decoder's own buffers come on top of the picture.
    limits.max_alloc = Some(texel_count * 8 + (16 << 20));
    reader.limits(limits);
    let rgba = reader.decode().map_err(wrong)?.into_rgba8();
    let (width, height) = rgba.dimensions();
    let mut texels = super::budget::reserve(texel_count, path)?;
    texels.extend_from_slice(rgba.as_raw().as_chunks::<4>().0);
    Ok(Texels { width, height, texels })
}
