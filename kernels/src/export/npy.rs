//! A stream as a NumPy array, format version 1.0 (NEP 1).
//!
//! The array's shape is (layer, row, column), its type `<f4` or `<u4` like the stream's texel: the bits are those of
//! the stream. Floats that a stream keeps as bits in an integer texel (t in `state`, u and v in `hit`) are read with
//! `array[1].view(numpy.float32)`.

use std::io::{self, Write};

use crate::renderer::cast::CastHit;
use crate::renderer::image::Image;
use crate::tables::stream::{StreamData, Texel};

/// Bytes before the data: magic, version, length and header, padded so that the data is aligned.
pub const HEADER_BYTES: u64 = 128;

/// Size of the whole file in bytes.
#[must_use]
pub fn file_bytes(data: &StreamData) -> u64 {
    HEADER_BYTES + 4 * data.bits.len() as u64
}

/// Writes a stream.
///
/// # Errors
/// If `out` fails.
pub fn write_stream(out: &mut impl Write, data: &StreamData) -> io::Result<()> {
    let kind = match data.stream.info().texel {
        Texel::F32 => "<f4",
        Texel::U32 => "<u4",
    };
    let shape = (data.stream.layers(), data.height, data.width);
    let shape = format!("{}, {}, {}", shape.0, shape.1, shape.2);
    out.write_all(&header(&format!("'{kind}'"), &shape, HEADER_BYTES as usize))?;
    // In pieces: a stream can take half of the memory.
    let mut bytes = Vec::with_capacity(4 << 14);
    for piece in data.bits.chunks(1 << 14) {
        bytes.clear();
        bytes.extend(piece.iter().flat_map(|bits| bits.to_le_bytes()));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// Appends an image as an array of shape (row, column, 4), `<f4`: r, g, b in linear light, and coverage.
pub fn write_image(out: &mut Vec<u8>, image: &Image) {
    out.extend(image_header(image.width, image.height));
    out.extend(image.pixels.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
}

/// Reads what [`write_image`] writes for an image of this size; `None` for anything else.
#[must_use]
pub fn read_image(bytes: &[u8], width: u32, height: u32) -> Option<Image> {
    let data = bytes.strip_prefix(image_header(width, height).as_slice())?;
    let (pixels, rest) = data.as_chunks::<16>();
    let is_whole = rest.is_empty() && pixels.len() as u64 == u64::from(width) * u64::from(height);
    let value = |pixel: &[u8; 16], c: usize| f32::from_le_bytes([0, 1, 2, 3].map(|i| pixel[4 * c + i]));
    let pixels = || pixels.iter().map(|pixel| [0, 1, 2, 3].map(|c| value(pixel, c))).collect();
    is_whole.then(|| Image { width, height, pixels: pixels() })
}

fn image_header(width: u32, height: u32) -> Vec<u8> {
    header("'<f4'", &format!("{height}, {width}, 4"), HEADER_BYTES as usize)
}

/// A header of so many bytes.
fn header(descr: &str, shape: &str, bytes: usize) -> Vec<u8> {
    let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': ({shape}), }}");
    // Magic, version and length take 10 bytes; the header ends in a line feed.
    let (length, width) = (bytes - 10, bytes - 11);
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend_from_slice(&(length as u16).to_le_bytes());
    header.extend_from_slice(format!("{text:<width$}\n").as_bytes());
    header
}

/// Bytes before the hits of a structured array, whatever their number.
pub const HITS_HEADER_BYTES: usize = 256;

/// Appends the header of a structured array of so many hits: t, u and v as `<f4`, triangle and material as `<u4`. It
/// always has the same length, so the number can be replaced later.
pub fn write_hits_header(out: &mut Vec<u8>, hits: u64) {
    let kinds = ["('t', '<f4')", "('u', '<f4')", "('v', '<f4')", "('triangle', '<u4')", "('material', '<u4')"];
    out.extend(header(&format!("[{}]", kinds.join(", ")), &format!("{hits},"), HITS_HEADER_BYTES));
}

/// Appends hits as the elements of that array, 20 bytes each.
pub fn write_hits(out: &mut Vec<u8>, hits: &[CastHit]) {
    out.reserve(size_of_val(hits));
    for hit in hits {
        for bits in [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.triangle, hit.material] {
            out.extend_from_slice(&bits.to_le_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::programs::closest_hit::streams;

    #[test]
    fn the_header_is_padded_and_the_bits_are_kept() {
        let bits: Vec<u32> = (0..3 * 2 * 5).map(|i| 0x7fc0_0000 + i).collect();
        for (stream, kind) in [(streams::RAY_ORIGIN, "<f4"), (streams::HIT, "<u4")] {
            let data = StreamData { stream, width: 5, height: 2, bits: bits.clone() };
            let mut file = Vec::new();
            write_stream(&mut file, &data).expect("memory");
            assert_eq!(file.len() as u64, file_bytes(&data));
            assert_eq!(&file[..10], b"\x93NUMPY\x01\x00\x76\x00");
            let header = std::str::from_utf8(&file[10..128]).expect("ASCII");
            let start = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (3, 2, 5), }}");
            assert_eq!(header.trim_end_matches(' ').strip_suffix('\n').map(str::trim_end), Some(start.as_str()));
            let read: Vec<u32> =
                file[128..].chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
            assert_eq!(read, bits);
        }
    }

    #[test]
    fn an_image_comes_back_and_nothing_else_does() {
        let pixels = (0..6).map(|i| [0.1, f32::INFINITY, -0.0, 1.0].map(|v| v * i as f32)).collect();
        let image = Image { width: 3, height: 2, pixels };
        let mut file = Vec::new();
        write_image(&mut file, &image);
        assert_eq!(file.len() as u64, HEADER_BYTES + 6 * 16);
        let again = read_image(&file, 3, 2).expect("its own");
        let bits = |image: &Image| image.pixels.as_flattened().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(&image));
        assert!(read_image(&file, 2, 3).is_none() && read_image(&file[..file.len() - 1], 3, 2).is_none());
        assert!(read_image(&[file.as_slice(), &[0; 16]].concat(), 3, 2).is_none());
    }
}
