//! What streams begin with: numbers, or files of numbers.

use std::io::Cursor;

use image::{ImageReader, Limits};

use super::reader::layers_in_words;
use crate::numbers::npy::Header;
use crate::tables::elements::{Count, Size};
use crate::tables::stream::{Stream, StreamData, Texel};

/// How a file holds values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Npy,
    Raw,
    Image,
}

/// A constant as WGSL writes it.
pub(super) fn constant(value: &toml::Value) -> Option<String> {
    match value {
        toml::Value::Boolean(value) => Some(value.to_string()),
        toml::Value::Integer(value) if (0..=i64::from(u32::MAX)).contains(value) => Some(format!("{value}u")),
        toml::Value::Integer(value) if i32::try_from(*value).is_ok() => Some(format!("i32({value})")),
        toml::Value::Float(value) if (*value as f32).is_finite() => Some(format!("f32({:?})", *value as f32)),
        toml::Value::Array(values) if (2..=4).contains(&values.len()) => {
            let is_float = values.iter().all(toml::Value::is_float);
            if !is_float && !values.iter().all(toml::Value::is_integer) {
                return None;
            }
            let parts = values.iter().map(constant).collect::<Option<Vec<_>>>()?;
            let kind = if is_float { "f32" } else { "u32" };
            // Negative integers have another type than the others.
            let is_one_type = is_float || parts.iter().all(|part| part.ends_with('u'));
            is_one_type.then(|| format!("vec{}<{kind}>({})", parts.len(), parts.join(", ")))
        }
        _ => None,
    }
}

/// The kernel that writes the first values.
pub(super) fn kernel(start: Option<&toml::Value>) -> Option<&str> {
    start?.get("kernel")?.as_str()
}

/// The file of the first values.
pub(super) fn file(start: Option<&toml::Value>) -> Option<(Kind, &str)> {
    let table = start?.as_table()?;
    [("npy", Kind::Npy), ("raw", Kind::Raw), ("image", Kind::Image)]
        .into_iter()
        .find_map(|(key, kind)| Some((kind, table.get(key)?.as_str()?)))
}

/// The first value of each layer, 0 if a file or a kernel has them.
pub(super) fn unwritten(start: Option<&toml::Value>, texel: Texel, layers: usize) -> Result<Vec<u32>, String> {
    let bits = |value: &toml::Value| {
        let number = match (value, texel) {
            (toml::Value::Float(value), Texel::F32) => Some((*value as f32).to_bits()),
            (toml::Value::Integer(value), Texel::F32) => Some((*value as f32).to_bits()),
            (toml::Value::Integer(value), Texel::U32) => u32::try_from(*value).ok(),
            (toml::Value::Boolean(value), Texel::U32) => Some(u32::from(*value)),
            _ => None,
        };
        number.ok_or_else(|| match texel {
            Texel::F32 => "`start`: expected a number".into(),
            Texel::U32 => "`start`: expected an integer from 0 to 4294967295".into(),
        })
    };
    match start {
        None => Ok(vec![0; layers]),
        Some(toml::Value::Array(values)) if values.len() == layers => values.iter().map(bits).collect(),
        Some(toml::Value::Array(values)) => {
            Err(format!("`start` has {} numbers, and the stream has {}", values.len(), layers_in_words(layers)))
        }
        Some(toml::Value::Table(table)) => {
            let is_known = table.len() == 1 && (file(start).is_some() || kernel(start).is_some());
            if is_known {
                return Ok(vec![0; layers]);
            }
            Err("`start`: expected a number, a list of numbers, or { npy = FILE }, { raw = FILE }, { image = FILE } or { kernel = NAME }".into())
        }
        Some(value) => Ok(vec![bits(value)?; layers]),
    }
}

/// The values of a file.
pub(super) fn read(stream: Stream, size: Size, kind: Kind, bytes: &[u8]) -> Result<StreamData, String> {
    let (layers, count) = (stream.layers(), size.count as usize);
    let is_image = stream.info().elements.count == Count::Image;
    let values = match kind {
        Kind::Npy => npy(stream, size, is_image, bytes)?,
        Kind::Raw => {
            if bytes.len() != 4 * layers * count {
                return Err(format!(
                    "it has {} bytes: expected {}, four for each of {count} elements in {}, layer by layer",
                    bytes.len(),
                    4 * layers * count,
                    layers_in_words(layers)
                ));
            }
            bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect()
        }
        Kind::Image => picture(stream, size, is_image, bytes)?,
    };
    // Texels behind the last element have no value.
    let texels = size.texels() as usize;
    let mut bits = Vec::with_capacity(layers * texels);
    for layer in values.chunks(count.max(1)).take(layers) {
        bits.extend_from_slice(layer);
        bits.resize(bits.len().next_multiple_of(texels.max(1)), 0);
    }
    bits.resize(layers * texels, 0);
    Ok(StreamData { stream, width: size.width, height: size.height, bits })
}

/// A shape as NumPy writes it.
fn shape(axes: &[u64]) -> String {
    match axes {
        [length] => format!("({length},)"),
        axes => format!("({})", axes.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// The values of a stream from an array of NumPy's, in any of the shapes and types that a stream may begin with.
///
/// # Errors
/// If it has another shape or type, or is damaged: what would be right.
pub fn array(stream: Stream, size: Size, bytes: &[u8]) -> Result<StreamData, String> {
    read(stream, size, Kind::Npy, bytes)
}

/// Components layer by layer, from an order in which those of an element are side by side.
fn by_layer(values: &[u32], layers: usize) -> Vec<u32> {
    (0..layers).flat_map(|layer| values.iter().skip(layer).step_by(layers).copied()).collect()
}

fn npy(stream: Stream, size: Size, is_image: bool, bytes: &[u8]) -> Result<Vec<u32>, String> {
    const TYPES: [&str; 7] = ["<f4", "<f8", "<u4", "<i4", "<i8", "|u1", "|b1"];
    let mut input = Cursor::new(bytes);
    let header = Header::read(&mut input).map_err(|error| error.to_string())?;
    let kind = header
        .expect_type(&TYPES, "float32, float64, uint32, int32, int64, uint8 or bool")
        .map_err(|e| e.to_string())?;
    let layers = stream.layers() as u64;
    let axes: Vec<u64> = if is_image { vec![size.height.into(), size.width.into()] } else { vec![size.count.into()] };
    let first: Vec<u64> = [layers].into_iter().chain(axes.iter().copied()).collect();
    let last: Vec<u64> = axes.iter().copied().chain([layers]).collect();
    // Rows and columns, as dumps have them.
    let has_rows = !is_image
        && header.shape.len() == 3
        && header.shape[0] == layers
        && header.shape[1].checked_mul(header.shape[2]) == Some(size.count.into());
    let is_by_layer = header.shape == first || layers == 1 && header.shape == axes || has_rows;
    if !is_by_layer && header.shape != last {
        let plain = if layers == 1 { format!("{}, ", shape(&axes)) } else { String::new() };
        return Err(header.wrong_shape(format!("{plain}{} or {}", shape(&first), shape(&last))).to_string());
    }
    let stride: usize = kind[2..].parse().unwrap_or(4);
    let data = &bytes[(input.position() as usize).min(bytes.len())..];
    let wanted = header.shape.iter().product::<u64>() as usize;
    if data.len() != wanted.saturating_mul(stride) {
        return Err(format!("it has {} bytes of numbers: expected {}", data.len(), wanted.saturating_mul(stride)));
    }
    let number = |bytes: &[u8]| -> Result<u32, String> {
        let mut wide = [0; 8];
        let is_negative = kind.as_bytes()[1] == b'i' && bytes[stride - 1] >= 0x80;
        wide.fill(if is_negative { 0xff } else { 0 });
        wide[..stride].copy_from_slice(bytes);
        let integer = i64::from_le_bytes(wide);
        let float = match kind {
            "<f4" => Some(f32::from_bits(integer as u32)),
            "<f8" => Some(f64::from_bits(integer as u64) as f32),
            _ => None,
        };
        match (stream.info().texel, float) {
            (Texel::F32, Some(float)) => Ok(float.to_bits()),
            (Texel::F32, None) => Ok((integer as f32).to_bits()),
            (Texel::U32, None) => u32::try_from(integer).map_err(|_| format!("{integer} is not a number of type u32")),
            (Texel::U32, Some(_)) => Err("its numbers are floats: the stream has type u32".into()),
        }
    };
    let values = data.chunks_exact(stride).map(number).collect::<Result<Vec<u32>, _>>()?;
    Ok(if is_by_layer { values } else { by_layer(&values, layers as usize) })
}

/// The channels of a picture, each a layer: from 0 to 1 in floats, 0 to 255 in integers. One layer has its brightness.
fn picture(stream: Stream, size: Size, is_image: bool, bytes: &[u8]) -> Result<Vec<u32>, String> {
    if !is_image {
        return Err("a picture is for elements that are the pixels of an image".into());
    }
    let layers = stream.layers();
    if !matches!(layers, 1 | 3 | 4) {
        return Err(format!("a picture has 1, 3 or 4 layers, and the stream has {layers}"));
    }
    let opened = || ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string());
    let (width, height) = opened()?.into_dimensions().map_err(|error| error.to_string())?;
    if (width, height) != (size.width, size.height) {
        return Err(format!("{width} x {height} pixels, expected {} x {}", size.width, size.height));
    }
    let mut reader = opened()?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(size.width.max(1));
    limits.max_image_height = Some(size.height.max(1));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let picture = image::DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?;
    let values: Vec<u8> = match layers {
        1 => picture.into_luma8().into_raw(),
        3 => picture.into_rgb8().into_raw(),
        _ => picture.into_rgba8().into_raw(),
    };
    let bits = |value: u8| match stream.info().texel {
        Texel::F32 => (f32::from(value) / 255.0).to_bits(),
        Texel::U32 => value.into(),
    };
    let values: Vec<u32> = values.into_iter().map(bits).collect();
    Ok(by_layer(&values, layers))
}
