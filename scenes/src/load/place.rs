//! Transforms meshes to world space: positions by a matrix, normals by its inverse transpose.

use glam::{DAffine3, DMat3, DVec3};

/// A transform, with what normals and mirrored meshes need.
pub(super) struct Placement {
    world: DAffine3,
    /// The inverse transpose up to a positive factor, so that it also exists for flat scales.
    normals: DMat3,
    /// Whether the transform mirrors: it then reverses the triangles' windings, and two vertices of each must be
    /// swapped so that the front stays on the side of the normals.
    pub(super) mirrors: bool,
}

impl Placement {
    pub(super) fn new(world: DAffine3) -> Self {
        let m = world.matrix3;
        // The cofactor matrix is the inverse transpose times the determinant. In f64 it is accurate for every scale
        // that keeps a triangle's vertices distinct in f32.
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let mirrors = m.x_axis.dot(cofactors.x_axis) < 0.0;
        Self { world, normals: if mirrors { -cofactors } else { cofactors }, mirrors }
    }

    /// The world position; may not be finite if the transform is extreme.
    pub(super) fn position(&self, p: DVec3) -> DVec3 {
        self.world.transform_point3(p)
    }

    /// The unit world normal, or zeros if there is none.
    pub(super) fn normal(&self, n: DVec3) -> [f32; 3] {
        unit(self.normals * n).unwrap_or_default()
    }
}

/// The unit vector along `v`, as f32. `None` if `v` is too short or not finite.
pub(super) fn unit(v: DVec3) -> Option<[f32; 3]> {
    // Scaled first: the square of a small vector's length may underflow.
    let size = v.abs().max_element();
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let unit = (v / size).normalize();
    unit.is_finite().then(|| unit.as_vec3().to_array())
}

/// The normal of a triangle's front; that of a triangle without area points along +Z.
pub(super) fn flat_normal([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = [a, b, c].map(|p| DVec3::from_array(p.map(f64::from)));
    unit((b - a).cross(c - a)).unwrap_or([0.0, 0.0, 1.0])
}
