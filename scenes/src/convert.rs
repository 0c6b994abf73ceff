//! Converts Wavefront OBJ and Stanford PLY to a [`Scene`], from bytes.
//!
//! Both formats say little about surfaces, so the result has one light grey material, double-sided because windings in
//! such files are unreliable, and neither lights nor cameras. Normals, texture coordinates and vertex colours are used
//! if present. Polygons become fans of triangles.

mod obj;
mod ply;

pub use obj::obj;
pub use ply::ply;

use crate::{Material, Note, Scene};
use glam::Vec3;

/// Why a file was not converted. One line each: what, where, and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConvertError {
    /// A line of text does not have the form that its first word requires.
    #[error("{file}, line {line}: {problem}")]
    Line {
        /// The file's name.
        file: String,
        /// Counting from 1.
        line: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// The file's structure is wrong.
    #[error("{file}: {problem}")]
    File {
        /// The file's name.
        file: String,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// An element is wrong.
    #[error("{file}: {element} {index} {problem}")]
    Element {
        /// The file's name.
        file: String,
        /// `vertex` or `face`.
        element: &'static str,
        /// Its index, counting from 0.
        index: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
}

/// A vertex of a face; its position is finite.
#[derive(Clone, Copy, Default)]
struct Corner {
    position: [f32; 3],
    normal: Option<[f32; 3]>,
    texcoord: Option<[f32; 2]>,
    color: Option<[f32; 3]>,
}

/// A scene under construction; its vertices may differ in which attributes they have.
struct Assembly {
    scene: Scene,
}

impl Assembly {
    fn new(file: &str) -> Self {
        let stem = file.rsplit(['/', '\\']).next().unwrap_or(file);
        let stem = stem.rsplit_once('.').map_or(stem, |(s, _)| s);
        let grey = Material {
            name: "light grey".to_owned(),
            base_color: [0.73; 3],
            double_sided: true,
            ..Material::default()
        };
        Self { scene: Scene { name: stem.to_owned(), materials: vec![grey], ..Scene::default() } }
    }

    fn note(&mut self, note: String) {
        self.scene.notes.push(Note(note));
    }

    /// A convex polygon of at least three vertices, as a fan.
    fn polygon(&mut self, corners: &[Corner]) {
        if let Some((&first, rest)) = corners.split_first() {
            for pair in rest.windows(2) {
                self.triangle([first, pair[0], pair[1]]);
            }
        }
    }

    fn triangle(&mut self, corners: [Corner; 3]) {
        let Scene { triangles, normals, texcoords, colors, triangle_materials, .. } = &mut self.scene;
        let triangle = corners.map(|c| c.position);
        // An attribute is added with the first vertex that has it; earlier triangles get its neutral value.
        if normals.is_none() && corners.iter().any(|c| c.normal.is_some()) {
            *normals = Some(triangles.iter().map(|t| [flat(t); 3]).collect());
        }
        if texcoords.is_none() && corners.iter().any(|c| c.texcoord.is_some()) {
            *texcoords = Some(vec![[[0.0; 2]; 3]; triangles.len()]);
        }
        if colors.is_none() && corners.iter().any(|c| c.color.is_some()) {
            *colors = Some(vec![[[1.0; 3]; 3]; triangles.len()]);
        }
        if let Some(normals) = normals {
            normals.push(corners.map(|c| c.normal.and_then(unit).unwrap_or_else(|| flat(&triangle))));
        }
        if let Some(texcoords) = texcoords {
            texcoords.push(corners.map(|c| c.texcoord.filter(|t| t.iter().all(|v| v.is_finite())).unwrap_or_default()));
        }
        if let Some(colors) = colors {
            colors.push(corners.map(|c| c.color.unwrap_or([1.0; 3])));
        }
        triangles.push(triangle);
        triangle_materials.push(0);
    }
}

/// The unit vector along `v`; `None` if `v` is 0 or not finite.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    // In f64, where the square of an f32 neither overflows nor underflows.
    Vec3::from(v).as_dvec3().try_normalize().map(|n| n.as_vec3().to_array())
}

fn flat(t: &[[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = t.map(|p| Vec3::from(p).as_dvec3());
    // A triangle without area is never shaded; any unit vector will do.
    (b - a).cross(c - a).try_normalize().map_or([0.0, 1.0, 0.0], |n| n.as_vec3().to_array())
}

/// sRGB in [0, 1] to linear (IEC 61966-2-1). Both formats' colours usually come from 8-bit tools.
fn linear(encoded: f32) -> f32 {
    let c = if encoded.is_nan() { 1.0 } else { encoded.clamp(0.0, 1.0) };
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}
