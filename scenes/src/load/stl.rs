//! STL (3D Systems, "Stereolithography Interface Specification", 1988): binary and ASCII.
//!
//! Normals are those of the triangles, so they are not read. A binary file may start with `solid`, too, and the number
//! of triangles in its header may be wrong; a text may hold several solids.
//!
//! We wrote our own reader because `stl_io` 0.11.0 rounds the numbers of a text to f32, so that a place far from the
//! origin cannot be subtracted first, and rejects a file with a number that is not finite or with another count.

use super::budget::Budget;
use super::mesh::{AttributesOf, Mesh};
use super::text::{self, number, split_line, split_word};
use super::{LoadError, at};
use crate::Scene;

/// Bytes before the triangles of a binary file: a comment and their number.
const HEADER_BYTES: usize = 84;
/// Bytes of a triangle: its normal, three vertices and two bytes for other uses.
const TRIANGLE_BYTES: usize = 50;

/// Whether the contents alone show that a file is STL: a binary file of the right length, or a text that starts well.
pub(super) fn is_certain(bytes: &[u8]) -> bool {
    let has_length_of =
        |count: u32| bytes.len() as u64 == HEADER_BYTES as u64 + u64::from(count) * TRIANGLE_BYTES as u64;
    promised(bytes).is_some_and(|count| count > 0 && has_length_of(count)) || is_text(bytes)
}

/// The number of triangles in the header of a binary file.
fn promised(bytes: &[u8]) -> Option<u32> {
    bytes.get(HEADER_BYTES - 4..)?.first_chunk().copied().map(u32::from_le_bytes)
}

/// Whether a file starts with the word `solid` and goes on like a text. Binary files have zeros: the highest byte of
/// their number of triangles is one.
fn is_text(bytes: &[u8]) -> bool {
    /// So long may the name of a solid be.
    const MOST: usize = 4096;
    let (word, rest) = split_word(text::trimmed(bytes));
    let start = rest.get(..MOST).unwrap_or(rest);
    let is_next = |next: &[u8]| start.windows(next.len()).any(|window| window.eq_ignore_ascii_case(next));
    word.eq_ignore_ascii_case(b"solid") && !start.contains(&0) && (is_next(b"facet") || is_next(b"endsolid"))
}

/// Reads an STL file.
pub(super) fn read(bytes: &[u8], budget: &Budget) -> Result<Scene, LoadError> {
    let mut mesh = Mesh::new(AttributesOf::Vertices, budget);
    if is_text(bytes) {
        ascii(text::without_mark(bytes), &mut mesh)?;
    } else {
        binary(bytes, &mut mesh)?;
    }
    mesh.scene(|first| match first {
        Some((face, fault)) => at(format!("facet {face}"), format!("{fault}, and no other facet can be drawn")),
        None => LoadError::Container("the STL file has no facet".into()),
    })
}

fn binary(bytes: &[u8], mesh: &mut Mesh<'_>) -> Result<(), LoadError> {
    let Some(promised) = promised(bytes) else {
        let problem =
            format!("a binary STL file starts with {HEADER_BYTES} bytes of header, but this has {}", bytes.len());
        return Err(LoadError::Container(problem));
    };
    let payload = bytes.get(HEADER_BYTES..).unwrap_or_default();
    let (triangles, rest) = payload.as_chunks::<TRIANGLE_BYTES>();
    let promised = promised as usize;
    // More triangles than promised are drawn if nothing else follows: some programs do not go back to count.
    let count = if promised > triangles.len() || rest.is_empty() { triangles.len() } else { promised };
    if count == 0 && !(promised == 0 && payload.is_empty()) {
        let problem = format!("the STL file promises {promised} triangles, but {} bytes follow", payload.len());
        return Err(LoadError::Container(format!("{problem}; each takes {TRIANGLE_BYTES}")));
    }
    if count != promised {
        mesh.notes.add(format!("the STL file promises {promised} triangles, but has {count}: all of them are drawn"));
    } else if count < triangles.len() || !rest.is_empty() {
        let more = payload.len() - count * TRIANGLE_BYTES;
        mesh.notes.add(format!("{more} bytes after the triangles of the STL file are ignored"));
    }
    mesh.reserve_vertices(3 * count as u64)?;
    mesh.reserve_faces(count as u64)?;
    for triangle in triangles.iter().take(count) {
        // The first three numbers are the normal.
        let (numbers, _) = triangle.as_chunks::<4>();
        let mut numbers = numbers.iter().skip(3).map(|bytes| f64::from(f32::from_le_bytes(*bytes)));
        for _ in 0..3 {
            let mut next = || numbers.next().unwrap_or(f64::NAN);
            corner([next(), next(), next()], mesh)?;
        }
        mesh.face(3)?;
    }
    Ok(())
}

/// Reads `facet … outer loop, vertex x y z, … endloop, endfacet`, in letters of any case.
fn ascii(text: &[u8], mesh: &mut Mesh<'_>) -> Result<(), LoadError> {
    let (mut rest, mut corners, mut is_in_facet) = (text, 0, false);
    loop {
        let (word, after) = split_word(rest);
        rest = after;
        let is = |keyword: &[u8]| word.eq_ignore_ascii_case(keyword);
        if is(b"solid") || is(b"endsolid") {
            rest = after_name(rest);
        } else if is(b"vertex") {
            let mut next = || {
                let (word, after) = split_word(rest);
                rest = after;
                number(word)
            };
            corner([next(), next(), next()], mesh)?;
            corners += 1;
        } else if is(b"facet") || is(b"endfacet") || word.is_empty() {
            if is_in_facet || corners > 0 {
                mesh.face(std::mem::take(&mut corners))?;
            }
            is_in_facet = is(b"facet");
        }
        if word.is_empty() {
            return Ok(());
        }
    }
}

/// What follows the name of a solid, which ends with the line, or before a facet if all is on one line.
fn after_name(text: &[u8]) -> &[u8] {
    const FACET: &[u8] = b"facet normal";
    let (name, rest) = split_line(text);
    let facet = name.windows(FACET.len()).position(|window| window.eq_ignore_ascii_case(FACET));
    facet.and_then(|facet| text.get(facet..)).unwrap_or(rest)
}

fn corner(position: [f64; 3], mesh: &mut Mesh<'_>) -> Result<(), LoadError> {
    let index = u32::try_from(mesh.positions.len()).unwrap_or(super::mesh::MISSING);
    mesh.position(position)?;
    mesh.vertex(index)
}
