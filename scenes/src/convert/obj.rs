//! Wavefront OBJ (Wavefront Technologies, "Advanced Visualizer Manual", appendix B1).
//!
//! We wrote our own reader because `tobj` 4.0.5 multiplies indices unchecked (`f 1//9223372036854775807` …), invents
//! normals if only some vertices have one, rejects a file with a byte in a comment that is not UTF-8, and does not
//! report the line of an error.

use super::{Assembly, ConvertError, Corner, linear};
use crate::Scene;

/// Reads the OBJ file `bytes`; `name` is used in messages and as the scene's name.
///
/// Reads `v` (with colours, if any, as sRGB), `vt`, `vn` and `f`, with positive and negative indices. Materials
/// (`mtllib`) are ignored with a note; lines, points, curves and groups are ignored.
///
/// # Errors
/// A number that cannot be read or is not finite, an index out of range, a face with fewer than three vertices, a file
/// without faces.
pub fn obj(name: &str, bytes: &[u8]) -> Result<Scene, ConvertError> {
    let mut reader = Reader { assembly: Assembly::new(name), positions: vec![], texcoords: vec![], normals: vec![] };
    let mut lines = bytes.split(|&b| b == b'\n').enumerate();
    let mut face = Vec::new();
    while let Some((index, line)) = lines.next() {
        let mut text = String::from_utf8_lossy(line);
        // A backslash at the end continues a line.
        while text.trim_end().ends_with('\\') {
            let Some((_, more)) = lines.next() else { break };
            let start = text.trim_end().trim_end_matches('\\').to_owned();
            text = (start + " " + &String::from_utf8_lossy(more)).into();
        }
        reader.line(&text, &mut face).map_err(|problem| ConvertError::Line {
            file: name.to_owned(),
            line: index + 1,
            problem,
        })?;
    }
    if reader.assembly.scene.triangles.is_empty() {
        let problem = "there is no face (a line like 'f 1 2 3'); only faces can be traced".to_owned();
        return Err(ConvertError::File { file: name.to_owned(), problem });
    }
    Ok(reader.assembly.scene)
}

struct Reader {
    assembly: Assembly,
    positions: Vec<([f32; 3], Option<[f32; 3]>)>,
    texcoords: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
}

impl Reader {
    /// `face` is scratch space.
    fn line(&mut self, text: &str, face: &mut Vec<Corner>) -> Result<(), String> {
        let text = text.split('#').next().unwrap_or_default();
        let mut words = text.split_whitespace();
        match words.next() {
            Some("v") => {
                let [x, y, z] = floats(&mut words, "v", "x y z")?;
                let rest: Vec<&str> = words.collect();
                // A fourth number is a weight, which only curves use; three more numbers are a colour.
                let color = match rest[..] {
                    [_, _, _, ..] => Some(floats(&mut rest.into_iter(), "v", "x y z r g b")?.map(linear)),
                    _ => None,
                };
                self.positions.push(([x, y, z], color));
            }
            Some("vt") => {
                let [u] = floats(&mut words, "vt", "u v")?;
                let v = if let Some(word) = words.next() { float(word)? } else { 0.0 };
                // In OBJ, v starts at the bottom of the image, in glTF at the top.
                self.texcoords.push([u, 1.0 - v]);
            }
            Some("vn") => self.normals.push(floats(&mut words, "vn", "x y z")?),
            Some("f") => {
                face.clear();
                for word in words {
                    face.push(self.corner(word)?);
                }
                if face.len() < 3 {
                    return Err(format!("a face of {}, but it needs at least 3 corners", face.len()));
                }
                self.assembly.polygon(face);
            }
            Some("mtllib") if self.assembly.scene.notes.is_empty() => {
                let file = words.collect::<Vec<_>>().join(" ");
                self.assembly.note(format!("materials of {file} are not read: everything is light grey"));
            }
            _ => {}
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: &str) -> Result<Corner, String> {
        let mut parts = word.split('/');
        let (position, color) = *at(&self.positions, parts.next().unwrap_or_default(), "vertex (v)")?;
        let texcoord = parts.next().filter(|p| !p.is_empty());
        let normal = parts.next().filter(|p| !p.is_empty());
        if parts.next().is_some() {
            return Err(format!("'{}' has too many slashes; a corner is v, v/vt, v//vn or v/vt/vn", cut(word)));
        }
        Ok(Corner {
            position,
            color,
            texcoord: texcoord.map(|p| at(&self.texcoords, p, "texture coordinate (vt)").copied()).transpose()?,
            normal: normal.map(|p| at(&self.normals, p, "normal (vn)").copied()).transpose()?,
        })
    }
}

/// Entry `word` of `list`: 1 is the first, −1 the most recent.
fn at<'a, T>(list: &'a [T], word: &str, what: &str) -> Result<&'a T, String> {
    let index: i64 = word.parse().map_err(|_| format!("'{}' is not the number of a {what}", cut(word)))?;
    let count = list.len();
    let found = match index {
        1.. => usize::try_from(index - 1).ok(),
        _ => usize::try_from(index.unsigned_abs()).ok().filter(|&i| i > 0).and_then(|back| count.checked_sub(back)),
    };
    let range = if count == 0 {
        "there is none before this line".to_owned()
    } else {
        format!("before this line there are 1 to {count}")
    };
    found.and_then(|i| list.get(i)).ok_or_else(|| format!("{what} {index} does not exist; {range}"))
}

fn floats<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a str>,
    kind: &str,
    form: &str,
) -> Result<[f32; N], String> {
    let mut out = [0.0; N];
    for slot in &mut out {
        *slot = float(words.next().ok_or_else(|| format!("too few numbers; right would be '{kind} {form}'"))?)?;
    }
    Ok(out)
}

fn float(word: &str) -> Result<f32, String> {
    match word.parse::<f32>() {
        Ok(v) if v.is_finite() => Ok(v),
        Ok(_) => Err(format!("'{}' is not finite in 32 bits", cut(word))),
        Err(_) => Err(format!("'{}' is not a number", cut(word))),
    }
}

/// Shortens a word, which may be megabytes long, for a message.
fn cut(word: &str) -> String {
    word.chars().take(40).collect()
}
