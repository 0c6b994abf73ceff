//! Stanford PLY (Turk 1994): ASCII and both binary orders.
//!
//! Reads a vertex's `x y z`, `nx ny nz`, `red green blue` (sRGB) and `s t`, `u v` or `texture_u texture_v`, and the
//! lists `vertex_indices` or `vertex_index` of faces and of `tristrips`. Everything else is skipped, and nothing is read
//! of what follows the last of these elements.
//!
//! We wrote our own reader because `ply-rs-bw` 4.0.1 and `serde-ply` 0.2.2 read ASCII line by line as UTF-8: they reject
//! blank lines, `\r` as the end of a line, and words such as `-nan(ind)` in numbers that nothing needs.

mod header;
mod values;

use super::budget::Budget;
use super::mesh::{AttributesOf, Fault, MISSING, Mesh};
use super::{LoadError, at};
use crate::Scene;
use header::{Element, Header, Kind, Type};
use values::Values;

/// The names of a vertex's properties, by where their values go in a [`Vertex`].
const PROPERTIES: [&[&str]; 11] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["s", "u", "texture_u"],
    &["t", "v", "texture_v"],
    &["red", "diffuse_red"],
    &["green", "diffuse_green"],
    &["blue", "diffuse_blue"],
];
const NORMAL: usize = 3;
const TEXCOORD: usize = 6;
const COLOR: usize = 8;

/// A vertex's values in the order of [`PROPERTIES`].
type Vertex = [f64; PROPERTIES.len()];

/// What is done with an element.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Use {
    Vertices,
    Faces,
    Strips,
    Nothing,
}

/// Reads a PLY file.
pub(super) fn read(bytes: &[u8], budget: &Budget) -> Result<Scene, LoadError> {
    let (header, payload) = Header::read(bytes, budget)?;
    let uses = uses(&header)?;
    let mut values = Values::new(&header, bytes, payload);
    let mut mesh = Mesh::new(AttributesOf::Vertices, budget);
    let last = uses.iter().rposition(|&what| what != Use::Nothing).map_or(0, |last| last + 1);
    for (element, what) in header.elements.iter().zip(uses).take(last) {
        if what != Use::Nothing {
            values.expect(element)?;
        }
        match what {
            Use::Vertices => vertices(element, &mut values, &mut mesh)?,
            Use::Faces => faces(element, &mut values, &mut mesh)?,
            Use::Strips => strips(element, &mut values, &mut mesh)?,
            Use::Nothing => values.skip(element)?,
        }
    }
    let count = mesh.positions.len();
    mesh.scene(|first| match first {
        Some((face, Fault::Missing(corner))) => {
            let problem = format!("its corner {corner} is none of the {count} vertices; no other face can be drawn");
            at(format!("face {face}"), problem)
        }
        Some((face, fault)) => at(format!("face {face}"), format!("{fault}, and no other face can be drawn")),
        None => no_faces(&header),
    })
}

/// What is done with each element.
fn uses(header: &Header<'_>) -> Result<Vec<Use>, LoadError> {
    let mut has_vertices = false;
    let uses = header.elements.iter().map(|element| match element.name {
        b"vertex" if !std::mem::replace(&mut has_vertices, true) => Use::Vertices,
        b"face" if element.corners().is_some() => Use::Faces,
        b"tristrips" if element.corners().is_some() => Use::Strips,
        _ => Use::Nothing,
    });
    let uses: Vec<_> = uses.collect();
    let vertices = header.elements.iter().find(|element| element.name == b"vertex" && element.count > 0);
    for axis in ["x", "y", "z"] {
        if vertices.is_none_or(|vertices| vertices.scalar(&[axis]).is_none()) {
            return Err(LoadError::Container(format!("there are no vertices with a property '{axis}'")));
        }
    }
    let is_drawn =
        |(element, what): (&Element<'_>, &Use)| element.count > 0 && matches!(what, Use::Faces | Use::Strips);
    if header.elements.iter().zip(&uses).any(is_drawn) { Ok(uses) } else { Err(no_faces(header)) }
}

/// The error for a file without faces.
fn no_faces(header: &Header<'_>) -> LoadError {
    let shown = |element: &Element<'_>| format!("{} of '{}'", element.count, super::text::shown(element.name));
    let others: Vec<_> = header.elements.iter().filter(|element| element.count > 0).map(shown).take(8).collect();
    let problem = "there are no faces with a list 'vertex_indices'";
    LoadError::Container(format!("{problem}, only {}; only faces and tristrips can be traced", others.join(", ")))
}

fn vertices(element: &Element<'_>, values: &mut Values<'_>, mesh: &mut Mesh<'_>) -> Result<(), LoadError> {
    let slots = element.properties.iter().map(|property| match property.kind {
        Kind::Scalar(_) => {
            PROPERTIES.iter().position(|names| names.iter().any(|name| name.as_bytes() == property.name))
        }
        Kind::List(..) => None,
    });
    let slots: Vec<_> = slots.collect();
    mesh.reserve_vertices(element.count)?;
    let has = |range: std::ops::Range<usize>| slots.iter().flatten().any(|slot| range.contains(slot));
    let (has_normals, has_texcoords) = (has(NORMAL..TEXCOORD), has(TEXCOORD..COLOR));
    let (has_v, has_colors) = (has(TEXCOORD + 1..COLOR), has(COLOR..PROPERTIES.len()));
    for index in 0..element.count {
        let mut vertex = Vertex::default();
        for (property, slot) in element.properties.iter().zip(&slots) {
            match (property.kind, slot.and_then(|slot| vertex.get_mut(slot))) {
                (Kind::Scalar(kind), Some(value)) => *value = values.next(kind).ok_or_else(|| element.ends(index))?,
                _ => values.skip_property(property, element, index)?,
            }
        }
        values.end_entry();
        let [x, y, z, nx, ny, nz, u, v, r, g, b] = vertex;
        mesh.position([x, y, z])?;
        if has_normals {
            mesh.normal([nx, ny, nz].map(|v| v as f32))?;
        }
        if has_texcoords {
            // PLY, like OBJ, starts v at the bottom of the image.
            mesh.texcoord([u as f32, if has_v { 1.0 - v as f32 } else { 0.0 }])?;
        }
        if has_colors {
            mesh.color([r, g, b].map(|v| v as f32))?;
        }
    }
    scale_colors(element, mesh);
    Ok(())
}

/// Decides which value of each channel is a full colour: the largest of its type, or 255 if that is more plausible.
fn scale_colors(element: &Element<'_>, mesh: &mut Mesh<'_>) {
    let channel = |i: usize| PROPERTIES.get(COLOR + i).and_then(|names| element.scalar(names));
    let types = [channel(0), channel(1), channel(2)];
    mesh.full = types.map(|kind| kind.map_or(1.0, |kind| kind.largest() as f32));
    mesh.guess_full(types.map(|kind| kind.is_some_and(Type::is_float)));
    let wide = types.map(|kind| kind.is_some_and(|kind| !kind.is_float() && kind.bytes() > 1));
    let parts = mesh.colors.iter().flatten().flat_map(|color| color.iter().zip(wide));
    let most = parts.filter(|(_, is_wide)| *is_wide).map(|(part, _)| *part).fold(0.0, f32::max);
    if most > 0.0 && most <= 255.0 {
        mesh.full_is_255(wide, most);
    }
}

/// Reads the list of corners of each entry of an element, and skips its other properties.
fn lists(
    element: &Element<'_>,
    values: &mut Values<'_>,
    mut each: impl FnMut(&mut Values<'_>, u64, u64, Type) -> Result<(), LoadError>,
) -> Result<(), LoadError> {
    let corners = element.corners();
    for index in 0..element.count {
        for (place, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List(count, kind) if Some(place) == corners => {
                    let count = values.count(count, element, index)?;
                    each(values, index, count, kind)?;
                }
                _ => values.skip_property(property, element, index)?,
            }
        }
        values.end_entry();
    }
    Ok(())
}

fn faces(element: &Element<'_>, values: &mut Values<'_>, mesh: &mut Mesh<'_>) -> Result<(), LoadError> {
    mesh.reserve_faces(element.count)?;
    lists(element, values, |values, index, count, kind| {
        for _ in 0..count {
            mesh.vertex(vertex(values.next(kind).ok_or_else(|| element.ends(index))?))?;
        }
        mesh.face(count)
    })
}

/// Strips of triangles, in which -1 starts another. Every other triangle is reversed, so that all face the same way.
fn strips(element: &Element<'_>, values: &mut Values<'_>, mesh: &mut Mesh<'_>) -> Result<(), LoadError> {
    lists(element, values, |values, index, count, kind| {
        let (mut last, mut is_odd) = ([None, None], false);
        for _ in 0..count {
            let value = values.next(kind).ok_or_else(|| element.ends(index))?;
            if value == -1.0 || kind.is_unsigned() && value == kind.largest() {
                (last, is_odd) = ([None, None], false);
                continue;
            }
            let c = vertex(value);
            if let [Some(a), Some(b)] = last {
                // Strips are joined by triangles without area.
                if a != b && b != c && c != a {
                    for corner in if is_odd { [a, c, b] } else { [a, b, c] } {
                        mesh.vertex(corner)?;
                    }
                    mesh.face(3)?;
                }
                is_odd = !is_odd;
            }
            last = [last[1], Some(c)];
        }
        Ok(())
    })
}

/// The vertex of an index.
fn vertex(index: f64) -> u32 {
    if index >= 0.0 && index < MISSING.into() && index.fract() == 0.0 { index as u32 } else { MISSING }
}
