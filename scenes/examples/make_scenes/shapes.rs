//! Meshes that the scenes share.

use std::f32::consts::TAU;

/// Positions, normals, texture coordinates and indices of a triangle list.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) texcoords: Vec<[f32; 2]>,
    pub(crate) indices: Vec<u16>,
}

/// A surface over u, v in 0..=1 with `columns` by `rows` cells and normals from differences. Counter-clockwise if ∂u ×
/// ∂v points to the viewer.
pub(crate) fn surface(columns: u16, rows: u16, at: impl Fn(f32, f32) -> [f32; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    let place = |u: f32, v: f32| glam::Vec3::from(at(u, v));
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (f32::from(column) / f32::from(columns), f32::from(row) / f32::from(rows));
            let e = 1e-3;
            let du = place(u + e, v) - place(u - e, v);
            let dv = place(u, v + e) - place(u, v - e);
            mesh.positions.push(at(u, v));
            mesh.normals.push(du.cross(dv).normalize_or(glam::Vec3::Y).to_array());
            mesh.texcoords.push([u, v]);
            if row < rows && column < columns {
                let (a, width) = (row * (columns + 1) + column, columns + 1);
                mesh.indices.extend([a, a + 1, a + width + 1, a, a + width + 1, a + width]);
            }
        }
    }
    mesh
}

pub(crate) fn torus(columns: u16, rows: u16, radius: f32, tube: f32) -> Mesh {
    surface(columns, rows, |u, v| {
        let (s, c) = (-u * TAU).sin_cos();
        let (t, d) = (v * TAU).sin_cos();
        let reach = radius + tube * d;
        [reach * c, tube * t, reach * s]
    })
}

pub(crate) fn cylinder(columns: u16, rows: u16, radius: f32, height: f32) -> Mesh {
    surface(columns, rows, |u, v| {
        let (s, c) = (-u * TAU).sin_cos();
        [radius * c, height * v, radius * s]
    })
}

/// A sphere that keeps the degenerate triangles at its poles: real files have spheres with and without them.
pub(crate) fn globe(columns: u16, rows: u16, radius: f32) -> Mesh {
    let mut mesh = surface(columns, rows, |u, v| {
        let (s, c) = (-u * TAU).sin_cos();
        let (t, d) = ((v - 0.5) * TAU * 0.5).sin_cos();
        [radius * d * c, radius * t, radius * d * s]
    });
    for (n, p) in mesh.normals.iter_mut().zip(&mesh.positions) {
        *n = p.map(|x| x / radius);
    }
    mesh
}

/// A horizontal square at y = 0, seen from above.
pub(crate) fn floor(half: f32, cells: u16) -> Mesh {
    surface(cells, cells, |u, v| [(2.0 * u - 1.0) * half, 0.0, (1.0 - 2.0 * v) * half])
}

/// An upright rectangle around the origin that faces +Z; v grows downwards, as in glTF.
pub(crate) fn panel(width: f32, height: f32) -> Mesh {
    let mut mesh = surface(1, 1, |u, v| [(u - 0.5) * width, (v - 0.5) * height, 0.0]);
    mesh.texcoords.iter_mut().for_each(|t| t[1] = 1.0 - t[1]);
    mesh
}

/// A box from `min` to `max` with flat sides: 24 vertices, 12 triangles.
pub(crate) fn block(min: [f32; 3], max: [f32; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in 0..2 {
            let base = mesh.positions.len() as u16;
            let (i, j) = if side == 1 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            for (u, v) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                let mut p = [0.0; 3];
                for (k, end) in [(axis, side), (i, u), (j, v)] {
                    p[k] = if end == 1 { max[k] } else { min[k] };
                }
                let mut n = [0.0; 3];
                n[axis] = if side == 1 { 1.0 } else { -1.0 };
                mesh.positions.push(p);
                mesh.normals.push(n);
                mesh.texcoords.push([u as f32, v as f32]);
            }
            mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| base + i));
        }
    }
    mesh
}

impl Mesh {
    /// Both meshes as one.
    pub(crate) fn and(mut self, other: Self) -> Self {
        let base = self.positions.len() as u16;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.texcoords.extend(other.texcoords);
        self.indices.extend(other.indices.into_iter().map(|i| i + base));
        self
    }
}
