//! Wavefront OBJ (Wavefront Technologies, "Advanced Visualizer Manual", appendix B1).
//!
//! Reads `v`, with colours if it has any, `vt`, `vn` and `f`, with indices from both ends, which may refer to what
//! follows. Materials are not read; points, lines, curves and surfaces are omitted, and groups have no effect.
//!
//! We wrote our own reader because `tobj` 4.0.5 multiplies indices unchecked (`f 1//9223372036854775807` …), invents
//! normals if only some vertices have one, rejects a file with a byte in a comment that is not UTF-8 or a number that
//! nothing needs, and does not report the line of an error.

use super::LoadError;
use super::budget::Budget;
use super::mesh::{AttributesOf, Corner, Fault, MISSING, Mesh, NONE};
use super::text::{self, number, split_line, split_word};
use crate::Scene;

/// Reads an OBJ file.
pub(super) fn read(bytes: &[u8], budget: &Budget) -> Result<Scene, LoadError> {
    let mesh = Mesh::new(AttributesOf::Corners, budget);
    let mut reader = Reader { mesh, others: Others::default(), has_library: false };
    for statement in statements(bytes) {
        reader.read(&statement)?;
    }
    let Reader { mut mesh, others, .. } = reader;
    mesh.guess_full([true; 3]);
    if others.points + others.lines > 0 {
        mesh.notes.add("points and lines are omitted");
    }
    if others.curves > 0 {
        mesh.notes.add("curves and surfaces of OBJ are omitted");
    }
    let vertices = mesh.positions.len() as u64;
    mesh.scene(|first| match first {
        Some((face, fault)) => nothing_right(bytes, face, fault),
        None => others.no_face(vertices),
    })
}

/// How much there is of what is not drawn.
#[derive(Clone, Copy, Default)]
struct Others {
    points: u64,
    lines: u64,
    curves: u64,
}

impl Others {
    /// The error for a file without faces.
    fn no_face(self, vertices: u64) -> LoadError {
        let parts = [
            (vertices, "vertex", "vertices"),
            (self.points, "point", "points"),
            (self.lines, "line", "lines"),
            (self.curves, "curve or surface", "curves or surfaces"),
        ];
        let named =
            |(count, one, many)| (count > 0).then(|| format!("{count} {}", if count == 1 { one } else { many }));
        let parts: Vec<String> = parts.into_iter().filter_map(named).collect();
        let only = if parts.is_empty() { String::new() } else { format!(", only {}", parts.join(", ")) };
        LoadError::Container(format!("there is no face (a line like 'f 1 2 3'){only}; only faces can be traced"))
    }
}

/// The error for a file none of whose faces can be drawn.
fn nothing_right(bytes: &[u8], face: usize, fault: Fault) -> LoadError {
    let faces = statements(bytes).filter(Statement::is_face);
    let line = faces.map(|statement| statement.line).nth(face).unwrap_or_default();
    LoadError::Line { line, problem: format!("no face of the file can be drawn; of this one, {fault}") }
}

/// A statement: a line, or several if all but the last end in a backslash.
struct Statement<'a> {
    /// The number of its first line, counted from 1.
    line: usize,
    keyword: &'a [u8],
    /// What follows the keyword, with comments and ends of lines.
    rest: &'a [u8],
}

impl<'a> Statement<'a> {
    fn is_face(&self) -> bool {
        matches!(self.keyword, b"f" | b"fo")
    }

    /// The words of a statement that is read.
    fn words(&self) -> impl Iterator<Item = &'a [u8]> {
        let mut rest = self.rest;
        std::iter::from_fn(move || {
            loop {
                rest = rest.trim_ascii_start();
                match rest.first()? {
                    b'#' => rest = split_line(rest).1,
                    b'\\' => rest = rest.get(1..)?,
                    _ => break,
                }
            }
            let is_end = |at: &usize| {
                let byte = rest.get(*at).copied().unwrap_or_default();
                byte.is_ascii_whitespace() || byte == b'\\' || starts_comment(rest, *at)
            };
            let (word, after) = rest.split_at((0..rest.len()).find(is_end).unwrap_or(rest.len()));
            rest = after;
            Some(word)
        })
    }
}

/// The statements of a file.
fn statements(bytes: &[u8]) -> impl Iterator<Item = Statement<'_>> {
    let mut rest = text::without_mark(bytes);
    let mut next_line = 1;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let line = next_line;
        let (keyword, _) = split_word(split_line(rest).0);
        // Other statements are not read. A name that ends in a backslash must not take the next line with it.
        let may_continue = matches!(keyword, b"v" | b"vt" | b"vn" | b"f" | b"fo");
        let (start, mut length) = (rest, 0);
        loop {
            let (physical, after) = split_line(rest);
            length += rest.len() - after.len();
            rest = after;
            next_line += 1;
            let is_continued = may_continue && before_comment(physical).trim_ascii_end().ends_with(b"\\");
            if !is_continued || rest.is_empty() {
                break;
            }
        }
        let whole = start.get(..length).unwrap_or_default();
        let rest = whole.trim_ascii_start().get(keyword.len()..).unwrap_or_default();
        Some(Statement { line, keyword, rest })
    })
}

/// Whether a comment starts at this byte, which is none of `1.#INF`, `1.#IND`, `1.#QNAN` and `1.#SNAN`.
fn starts_comment(text: &[u8], at: usize) -> bool {
    let is_number = || {
        let after = text.get(at + 1..).unwrap_or_default();
        let is_next = [&b"IN"[..], b"QNAN", b"SNAN"].iter().any(|word| after.starts_with(word));
        is_next && at.checked_sub(1).and_then(|before| text.get(before)) == Some(&b'.')
    };
    text.get(at) == Some(&b'#') && !is_number()
}

fn before_comment(line: &[u8]) -> &[u8] {
    (0..line.len()).find(|&at| starts_comment(line, at)).and_then(|at| line.get(..at)).unwrap_or(line)
}

struct Reader<'a> {
    mesh: Mesh<'a>,
    others: Others,
    has_library: bool,
}

impl Reader<'_> {
    fn read(&mut self, statement: &Statement<'_>) -> Result<(), LoadError> {
        let mut words = statement.words();
        let mut next = || words.next().map_or(f64::NAN, number);
        match statement.keyword {
            b"v" => {
                self.mesh.position([next(), next(), next()])?;
                self.color(words)?;
            }
            b"vt" => {
                let u = next() as f32;
                let v = words.next().map_or(0.0, number) as f32;
                // In OBJ, v starts at the bottom of the image, in glTF at the top.
                self.mesh.texcoord([u, 1.0 - v])?;
            }
            b"vn" => self.mesh.normal([next() as f32, next() as f32, next() as f32])?,
            b"f" | b"fo" => {
                let mut corners = 0;
                for word in words {
                    self.mesh.corner(self.corner(word))?;
                    corners += 1;
                }
                self.mesh.face(corners)?;
            }
            b"p" => self.others.points += 1,
            b"l" => self.others.lines += 1,
            b"curv" | b"curv2" | b"surf" => self.others.curves += 1,
            b"mtllib" => self.library(statement.rest),
            _ => {}
        }
        Ok(())
    }

    /// The colour of the last vertex: `x y z r g b` or, after a weight, `x y z w r g b`.
    fn color<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<(), LoadError> {
        let (mut parts, mut count) = ([0.0; 4], 0);
        for (part, word) in parts.iter_mut().zip(words) {
            *part = number(word) as f32;
            count += 1;
        }
        let [a, b, c, d] = parts;
        match count {
            3 => self.mesh.color([a, b, c]),
            4 => self.mesh.color([b, c, d]),
            // A fourth number alone is a weight, which only curves use.
            _ => Ok(()),
        }
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: &[u8]) -> Corner {
        let mut parts = word.split(|&byte| byte == b'/');
        let position = index(parts.next().unwrap_or_default(), self.mesh.positions.len());
        let mut attribute =
            |count| parts.next().filter(|part| !part.is_empty()).map_or(NONE, |part| index(part, count));
        let texcoord = attribute(self.mesh.texcoords.len());
        let normal = attribute(self.mesh.normals.len());
        Corner { position, normal, texcoord }
    }

    /// Notes the first library of materials.
    fn library(&mut self, rest: &[u8]) {
        if !std::mem::replace(&mut self.has_library, true) {
            let file = text::shown(before_comment(rest).trim_ascii());
            self.mesh.notes.add(format!("materials of {file} are not read: everything is light grey"));
        }
    }
}

/// The entry that a word names: 1 is the first of all, −1 the last of these.
fn index(word: &[u8], count: usize) -> u32 {
    let index: Option<i64> = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    let found = index.and_then(|index| match index {
        1.. => u64::try_from(index - 1).ok(),
        _ => (count as u64).checked_sub(index.unsigned_abs()).filter(|_| index < 0),
    });
    found.and_then(|found| u32::try_from(found).ok()).filter(|&found| found < MISSING).unwrap_or(MISSING)
}
