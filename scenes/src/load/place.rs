//! From a mesh's space to the world: positions by a matrix, normals by its inverse transpose.

use glam::{DAffine3, DMat3, DVec3};

/// A transform with what normals and mirrored meshes need of it.
pub(super) struct Placement {
    world: DAffine3,
    /// The inverse transpose up to a positive factor, so that it exists for flat scales as well.
    normals: DMat3,
    /// Whether the transform mirrors: the triangles' corners then turn the other way round, and two
    /// of them are to be swapped so that their front stays where their normals point.
    pub(super) mirrors: bool,
}

impl Placement {
    pub(super) fn new(world: DAffine3) -> Self {
        let m = world.matrix3;
        // The cofactor matrix is the inverse transpose times the determinant. In f64 it holds for
        // every scale that leaves a triangle its corners in f32.
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let mirrors = m.x_axis.dot(cofactors.x_axis) < 0.0;
        Self { world, normals: if mirrors { -cofactors } else { cofactors }, mirrors }
    }

    /// The world position; maybe not finite where the transform is extreme.
    pub(super) fn position(&self, p: [f32; 3]) -> [f32; 3] {
        self.world.transform_point3(DVec3::from_array(p.map(f64::from))).as_vec3().to_array()
    }

    /// The unit world normal, or zeros where there is none.
    pub(super) fn normal(&self, n: [f32; 3]) -> [f32; 3] {
        unit(self.normals * DVec3::from_array(n.map(f64::from))).unwrap_or_default()
    }
}

/// The unit vector along `v` as f32s. None where `v` is too short or not finite.
pub(super) fn unit(v: DVec3) -> Option<[f32; 3]> {
    // Scaled first: the square of a small vector's length may be 0.
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
