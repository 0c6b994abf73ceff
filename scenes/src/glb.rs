//! Writes any [`Scene`] as a GLB, the binary form of glTF 2.0 (Khronos Group 2021, §4.4): a header, a chunk of JSON, a
//! chunk of bytes.
//!
//! One mesh with one primitive per material, in the order of the materials; within a material, triangles keep their
//! order. Coordinates are written as f32, unchanged; a node at the scene's offset has everything in it. Vertices with
//! bit-identical attributes are shared if the indices take less space than they save.

mod document;
mod vertices;

use crate::Scene;
use document::Document;
use vertices::Primitive;

/// Why a scene cannot be written as GLB.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// A GLB's size is a 32-bit number.
    #[error("the scene needs {bytes} bytes as GLB, and a GLB has at most {limit}", limit = u32::MAX)]
    TooLarge {
        /// The file's size, or a lower bound if that is already too large.
        bytes: u64,
    },
    /// A list of the scene has the wrong length.
    #[error("the scene's {list} has {actual} entries for {expected} triangles or texels")]
    WrongLength {
        /// The field of [`Scene`] or [`Texture`](crate::Texture).
        list: &'static str,
        /// Its length.
        actual: usize,
        /// The correct length.
        expected: usize,
    },
    /// An entry of the scene has no glTF form.
    #[error("{list}[{index}] {problem}")]
    Invalid {
        /// The field of [`Scene`].
        list: &'static str,
        /// The entry.
        index: usize,
        /// What is wrong with it, and what was expected.
        problem: &'static str,
    },
    /// A texture was not encoded as PNG.
    #[error("textures[{index}] was not encoded as PNG: {reason}")]
    Png {
        /// The texture.
        index: usize,
        /// The encoder's message.
        reason: String,
    },
}

/// `scene` as the bytes of a GLB.
///
/// Memory: the file itself, 4 bytes per triangle, and, if vertices are shared, about 35 more bytes per triangle of
/// the current primitive. Materials without triangles are kept; [`Scene::notes`] are not written, nor is a light's
/// range, which [`Scene`] does not store.
///
/// # Errors
/// More than 4 GiB; positions that are not finite; colours outside \[0, 1\]; lists of the wrong length.
pub fn write_glb(scene: &Scene) -> Result<Vec<u8>, WriteError> {
    check(scene)?;
    // Shared or not, a triangle takes at least three 2-byte indices, and vertex ids must fit into 32 bits.
    let least = scene.triangles.len() as u64 * 6;
    if least > u64::from(u32::MAX) {
        return Err(WriteError::TooLarge { bytes: least });
    }
    let order = by_material(scene);
    let mut start = 0;
    let mut document = Document::new(scene)?;
    let mut primitives = Vec::new();
    for (material, count) in order.counts.iter().enumerate() {
        if *count > 0 {
            let primitive = Primitive::new(scene, &order.ids[start..start + count]);
            document.primitive(material, &primitive);
            primitives.push(primitive);
        }
        start += count;
    }
    let (json, images, binary) = document.finish();
    let chunk = |bytes: u64| 8 + bytes;
    let total = 12 + chunk(json.len() as u64) + if binary == 0 { 0 } else { chunk(binary) };
    let length = u32::try_from(total).map_err(|_| WriteError::TooLarge { bytes: total })?;

    let mut out = Vec::with_capacity(total as usize);
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend(length.to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(&json);
    if binary > 0 {
        // `total` fits 32 bits, so its parts do.
        out.extend((binary as u32).to_le_bytes());
        out.extend(b"BIN\0");
        for image in &images {
            out.extend(image);
            out.resize(out.len().next_multiple_of(4), 0);
        }
        for primitive in &primitives {
            primitive.write(scene, &mut out);
        }
    }
    debug_assert_eq!(out.len() as u64, total);
    Ok(out)
}

/// The ids of all triangles, sorted by material, stable.
struct Order {
    ids: Vec<u32>,
    /// Number of triangles per material.
    counts: Vec<usize>,
}

fn by_material(scene: &Scene) -> Order {
    let mut counts = vec![0; scene.materials.len()];
    for &m in &scene.triangle_materials {
        counts[m as usize] += 1;
    }
    let mut next: Vec<usize> = counts.iter().scan(0, |sum, &c| Some(std::mem::replace(sum, *sum + c))).collect();
    let mut ids = vec![0; scene.triangles.len()];
    for (id, &m) in scene.triangle_materials.iter().enumerate() {
        ids[next[m as usize]] = id as u32;
        next[m as usize] += 1;
    }
    Order { ids, counts }
}

/// Checks everything that the writer relies on.
fn check(scene: &Scene) -> Result<(), WriteError> {
    let expected = scene.triangles.len();
    let lengths = [
        ("triangle_materials", Some(scene.triangle_materials.len())),
        ("normals", scene.normals.as_ref().map(Vec::len)),
        ("texcoords", scene.texcoords.as_ref().map(Vec::len)),
        ("colors", scene.colors.as_ref().map(Vec::len)),
    ];
    for (list, actual) in lengths {
        if let Some(actual) = actual.filter(|&a| a != expected) {
            return Err(WriteError::WrongLength { list, actual, expected });
        }
    }
    each("offset", &[scene.offset], "is not finite", |offset| offset.is_finite())?;
    each("triangles", &scene.triangles, "has a coordinate that is not finite", |t| finite(t.as_flattened()))?;
    each("triangle_materials", &scene.triangle_materials, "names a material that the scene does not have", |&m| {
        (m as usize) < scene.materials.len()
    })?;
    let normals = scene.normals.as_deref().unwrap_or_default();
    each("normals", normals, "has a coordinate that is not finite", |t| finite(t.as_flattened()))?;
    let texcoords = scene.texcoords.as_deref().unwrap_or_default();
    each("texcoords", texcoords, "has a coordinate that is not finite", |t| finite(t.as_flattened()))?;
    let colors = scene.colors.as_deref().unwrap_or_default();
    each("colors", colors, "is outside [0, 1]", |t| t.as_flattened().iter().all(|c| (0.0..=1.0).contains(c)))?;
    each("materials", &scene.materials, "has a colour outside [0, 1], or emits negative or too much light", |m| {
        m.base_color.iter().all(|c| (0.0..=1.0).contains(c))
            && m.emissive.iter().all(|light| (0.0..=f32::from_bits(0x7f00_0000)).contains(light))
    })?;
    each("materials", &scene.materials, "names a texture that the scene does not have", |m| {
        m.texture.is_none_or(|t| (t as usize) < scene.textures.len())
    })?;
    for t in &scene.textures {
        let expected = u64::from(t.width) * u64::from(t.height);
        if expected == 0 || t.texels.len() as u64 != expected {
            let expected = usize::try_from(expected).unwrap_or(usize::MAX).max(1);
            return Err(WriteError::WrongLength { list: "textures' texels", actual: t.texels.len(), expected });
        }
    }
    document::check_placed(scene)
}

fn each<T>(
    list: &'static str,
    items: &[T],
    problem: &'static str,
    good: impl Fn(&T) -> bool,
) -> Result<(), WriteError> {
    match items.iter().position(|i| !good(i)) {
        Some(index) => Err(WriteError::Invalid { list, index, problem }),
        None => Ok(()),
    }
}

fn finite(values: &[f32]) -> bool {
    values.iter().all(|v| v.is_finite())
}
