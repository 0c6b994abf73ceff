//! A stream as a NumPy array, format version 1.0 (NEP 1).
//!
//! The array's shape is (layer, row, column), its type `<f4` or `<u4` like the stream's texel: the bits are those of
//! the stream. Floats that a stream keeps as bits in an integer texel (t in `state`, u and v in `hit`) are read with
//! `array[1].view(numpy.float32)`.

use std::io::{self, Write};

use crate::renderer::cast::CastHit;

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
    let header =
        format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}, {}, {}), }}", shape.0, shape.1, shape.2);
    // Magic, version and length take 10 bytes; the header ends in a line feed.
    let width = HEADER_BYTES as usize - 11;
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(HEADER_BYTES as u16 - 10).to_le_bytes())?;
    writeln!(out, "{header:<width$}")?;
    // In pieces: a stream can take half of the memory.
    let mut bytes = Vec::with_capacity(4 << 14);
    for piece in data.bits.chunks(1 << 14) {
        bytes.clear();
        bytes.extend(piece.iter().flat_map(|bits| bits.to_le_bytes()));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// Bytes before the hits of a structured array, whatever their number.
pub const HITS_HEADER_BYTES: usize = 256;

/// Appends the header of a structured array of so many hits: t, u and v as `<f4`, triangle and material as `<u4`. It
/// always has the same length, so the number can be replaced later.
pub fn write_hits_header(out: &mut Vec<u8>, hits: u64) {
    let kinds = ["('t', '<f4')", "('u', '<f4')", "('v', '<f4')", "('triangle', '<u4')", "('material', '<u4')"];
    let header = format!("{{'descr': [{}], 'fortran_order': False, 'shape': ({hits},), }}", kinds.join(", "));
    let width = HITS_HEADER_BYTES - 11;
    out.extend_from_slice(b"\x93NUMPY\x01\x00");
    out.extend_from_slice(&(HITS_HEADER_BYTES as u16 - 10).to_le_bytes());
    out.extend_from_slice(format!("{header:<width$}\n").as_bytes());
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
}
