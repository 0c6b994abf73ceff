//! A stream as a NumPy array, format version 1.0 (NEP 1).
//!
//! The array's shape is (layer, row, column), its type `<f4` or `<u4` like the stream's texel: the bits are those of
//! the stream. Floats that a stream keeps as bits in an integer texel (t in `state`, u and v in `hit`) are read with
//! `array[1].view(numpy.float32)`.

use std::io::{self, Write};

use naga::ScalarKind;

use crate::renderer::all_hits::AllHits;
use crate::renderer::cast::CastHit;
use crate::renderer::image::Image;
use crate::scene_data::buffer::BufferInfo;
use crate::shader::{ArrayLayout, Field};
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
    let is_float = data.stream.info().texel == Texel::F32;
    write_bits(out, is_float, [data.stream.layers() as u32, data.height, data.width], &data.bits)
}

/// Writes numbers of 32 bits, floats or integers without sign, as an array of shape (layer, row, column).
///
/// # Errors
/// If `out` fails.
pub fn write_bits(out: &mut impl Write, is_float: bool, shape: [u32; 3], bits: &[u32]) -> io::Result<()> {
    let kind = if is_float { "'<f4'" } else { "'<u4'" };
    let shape = format!("{}, {}, {}", shape[0], shape[1], shape[2]);
    out.write_all(&header(kind, &shape, HEADER_BYTES as usize))?;
    // In pieces: a stream can take half of the memory.
    let mut bytes = Vec::with_capacity(4 << 14);
    for piece in bits.chunks(1 << 14) {
        bytes.clear();
        bytes.extend(piece.iter().flat_map(|bits| bits.to_le_bytes()));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// Writes a buffer of scene data: scalars and vectors as an array of them, structs as an array of records.
///
/// # Errors
/// If `out` fails.
pub fn write_buffer(out: &mut impl Write, buffer: &BufferInfo, layout: &ArrayLayout, bytes: &[u8]) -> io::Result<()> {
    let kind = |field: &Field| match field.kind {
        ScalarKind::Float | ScalarKind::AbstractFloat => "<f4",
        ScalarKind::Sint | ScalarKind::AbstractInt => "<i4",
        ScalarKind::Uint | ScalarKind::Bool => "<u4",
    };
    let elements = bytes.len() as u64 / u64::from(layout.stride.max(1));
    let axis = |count: u32| if count == 1 { Vec::new() } else { vec![count] };
    let (descr, per_element) = match &layout.fields[..] {
        [field] if field.name.is_empty() => (format!("'{}'", kind(field)), axis(field.count)),
        fields => (format!("[{}]", records(fields, layout.stride, kind)), Vec::new()),
    };
    let per_row = buffer.rows.iter().map(|&n| u64::from(n)).product::<u64>();
    let axes = buffer.rows.iter().copied().chain(per_element).map(|n| n.to_string());
    let shape: Vec<String> = std::iter::once((elements / per_row).to_string()).chain(axes).collect();
    let shape = if shape.len() == 1 { shape[0].clone() + "," } else { shape.join(", ") };
    let length = descr.len() + shape.len() + 80;
    out.write_all(&header(&descr, &shape, length.next_multiple_of(64)))?;
    out.write_all(bytes)
}

/// The members of a record, and what lies between them.
fn records(fields: &[Field], stride: u32, kind: impl Fn(&Field) -> &'static str) -> String {
    let mut parts = Vec::new();
    let mut at = 0;
    let mut pad = |parts: &mut Vec<String>, to: u32, next: u32| {
        if to > at {
            parts.push(format!("('', '|V{}')", to - at));
        }
        at = next;
    };
    for field in fields {
        pad(&mut parts, field.offset, field.offset + 4 * field.count);
        let axis = if field.count == 1 { String::new() } else { format!(", ({},)", field.count) };
        parts.push(format!("('{}', '{}'{axis})", field.name, kind(field)));
    }
    pad(&mut parts, stride, stride);
    parts.join(", ")
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

/// What is known of a hit, in the order of [`CastHit`], with NumPy's types.
pub const HIT_FIELDS: [(&str, &str); 5] =
    [("t", "<f4"), ("u", "<f4"), ("v", "<f4"), ("triangle", "<u4"), ("material", "<u4")];

/// What all hits of rays have before that: which ray it is.
pub const RAY_FIELD: (&str, &str) = ("ray", "<u8");

/// Hits to write: one of each ray, or all of them.
#[derive(Clone, Copy, Debug)]
pub enum Hits<'a> {
    /// One of each ray.
    Each(&'a [CastHit]),
    /// All, with the number of each hit's ray.
    All(&'a AllHits),
}

/// Arrays of hits. Their headers have [`HITS_HEADER_BYTES`], so that the number in it can be replaced later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitsArray {
    /// An array of records, with [`HIT_FIELDS`], and [`RAY_FIELD`] before them if all hits are written.
    Structured,
    /// An array of `<f8` with a column for each of these, for readers without records; triangle and material are −1
    /// without a hit.
    Plain,
    /// An array of one of the fields of a hit.
    Field(usize),
    /// The rays of all hits.
    Rays,
}

/// Bytes before the hits, whatever their number.
pub const HITS_HEADER_BYTES: usize = 256;

impl HitsArray {
    /// The header of so many hits; `is_all`: of all hits of rays.
    #[must_use]
    pub fn header(self, hits: u64, is_all: bool) -> Vec<u8> {
        let fields = || Some(RAY_FIELD).filter(|_| is_all).into_iter().chain(HIT_FIELDS);
        let (descr, shape) = match self {
            Self::Structured => {
                let kinds: Vec<String> = fields().map(|(name, kind)| format!("('{name}', '{kind}')")).collect();
                (format!("[{}]", kinds.join(", ")), format!("{hits},"))
            }
            Self::Plain => ("'<f8'".into(), format!("{hits}, {}", fields().count())),
            Self::Field(field) => (format!("'{}'", HIT_FIELDS[field].1), format!("{hits},")),
            Self::Rays => (format!("'{}'", RAY_FIELD.1), format!("{hits},")),
        };
        header(&descr, &shape, HITS_HEADER_BYTES)
    }

    /// Appends hits.
    pub fn write(self, out: &mut Vec<u8>, hits: Hits<'_>) {
        let (rays, hits) = match hits {
            Hits::Each(hits) if self == Self::Structured && cfg!(target_endian = "little") => {
                return out.extend_from_slice(bytemuck::cast_slice(hits));
            }
            Hits::Each(hits) => (&[][..], hits),
            Hits::All(all) => (&all.rays[..], &all.hits[..]),
        };
        for (index, hit) in hits.iter().enumerate() {
            match (self, rays.get(index)) {
                (Self::Structured | Self::Rays, Some(ray)) => out.extend(ray.to_le_bytes()),
                (Self::Plain, Some(&ray)) => out.extend((ray as f64).to_le_bytes()),
                _ => {}
            }
            let words = [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.triangle, hit.material];
            match self {
                Self::Structured => out.extend(words.iter().flat_map(|word| word.to_le_bytes())),
                Self::Field(field) => out.extend(words[field].to_le_bytes()),
                Self::Rays => {}
                Self::Plain => {
                    let id = |id: u32| if hit.is_hit() { f64::from(id) } else { -1.0 };
                    let [t, u, v] = [hit.t, hit.u, hit.v].map(f64::from);
                    let numbers = [t, u, v, id(hit.triangle), id(hit.material)];
                    out.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
                }
            }
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

    #[test]
    fn hits_are_records_numbers_or_fields() {
        let hit = CastHit { t: 1.5, u: 0.25, v: 0.5, triangle: (1 << 24) + 1, material: 2 };
        let written = |array: HitsArray| {
            let mut bytes = array.header(2, false);
            assert_eq!(bytes.len(), HITS_HEADER_BYTES);
            let header = String::from_utf8_lossy(&bytes[10..]).trim_end().to_owned();
            bytes.clear();
            array.write(&mut bytes, Hits::Each(&[hit, CastHit::MISS]));
            (header, bytes)
        };
        let (header, records) = written(HitsArray::Structured);
        assert!(header.contains("('v', '<f4'), ('triangle', '<u4')") && header.contains("'shape': (2,)"), "{header}");
        assert_eq!((records.len(), &records[12..16]), (40, &hit.triangle.to_le_bytes()[..]));
        let (header, numbers) = written(HitsArray::Plain);
        assert!(header.contains("'descr': '<f8'") && header.contains("'shape': (2, 5)"), "{header}");
        let (numbers, _) = numbers.as_chunks::<8>();
        let numbers: Vec<f64> = numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        // More than f32 could tell from its neighbours.
        assert_eq!(numbers[..5], [1.5, 0.25, 0.5, 16_777_217.0, 2.0]);
        assert_eq!(numbers[5..], [f64::INFINITY, 0.0, 0.0, -1.0, -1.0]);
        let (header, triangles) = written(HitsArray::Field(3));
        assert!(header.contains("'descr': '<u4'") && header.contains("'shape': (2,)"), "{header}");
        assert_eq!(triangles, [hit.triangle, u32::MAX].map(u32::to_le_bytes).concat());
    }

    #[test]
    fn all_hits_say_whose_they_are() {
        let hits = [1.0, 2.0].map(|t| CastHit { t, u: 0.25, v: 0.5, triangle: 7, material: 2 });
        let all = AllHits { rays: vec![3, 1 << 40], hits: hits.to_vec() };
        let written = |array: HitsArray| {
            let mut bytes = array.header(2, true);
            assert_eq!(bytes.len(), HITS_HEADER_BYTES);
            let header = String::from_utf8_lossy(&bytes[10..]).trim_end().to_owned();
            bytes.clear();
            array.write(&mut bytes, Hits::All(&all));
            (header, bytes)
        };
        let (header, records) = written(HitsArray::Structured);
        assert!(header.contains("[('ray', '<u8'), ('t', '<f4'), ") && header.contains("'shape': (2,)"), "{header}");
        assert_eq!((records.len(), &records[28..36]), (56, &(1u64 << 40).to_le_bytes()[..]));
        assert_eq!(records[36..40], 2.0f32.to_le_bytes());
        let (header, numbers) = written(HitsArray::Plain);
        assert!(header.contains("'shape': (2, 6)"), "{header}");
        let numbers: Vec<f64> = numbers.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        assert_eq!(numbers[..6], [3.0, 1.0, 0.25, 0.5, 7.0, 2.0]);
        assert_eq!(numbers[6], (1u64 << 40) as f64);
        let (header, rays) = written(HitsArray::Rays);
        assert!(header.contains("'descr': '<u8'"), "{header}");
        assert_eq!(rays, all.rays.iter().flat_map(|ray| ray.to_le_bytes()).collect::<Vec<_>>());
    }
}
