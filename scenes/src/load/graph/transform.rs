//! The transform of one node.

use crate::load::json::{Node, Property};
use crate::load::{LoadError, at};
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Parent from node `i`.
pub(super) fn local(node: &Property<Node<'_>>, i: usize) -> Result<DAffine3, LoadError> {
    let node = node.need(|| format!("nodes[{i}]"))?;
    let path = |field: &'static str| move || format!("nodes[{i}].{field}");
    if let Some(matrix) = node.matrix.numbers::<16>(path("matrix"))? {
        let [.., t3] = matrix;
        let last_row = [matrix[3], matrix[7], matrix[11], t3 - 1.0];
        // Exporters that multiply matrices leave small rounding errors here.
        if last_row.iter().any(|v| v.abs() > 1e-4) {
            let problem = "has a last row that is not 0 0 0 1; only affine transforms are allowed";
            return Err(at(path("matrix")(), problem));
        }
        return Ok(affine(matrix));
    }
    let translation = node.translation.numbers(path("translation"))?.unwrap_or_default();
    let rotation = node.rotation.numbers(path("rotation"))?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = node.scale.numbers(path("scale"))?.unwrap_or([1.0; 3]);
    Ok(scaled_rotated_moved(scale, rotation, translation))
}

/// The transform of a 4 × 4 matrix, column by column, without its last row.
pub(in crate::load) fn affine(columns: [f64; 16]) -> DAffine3 {
    let [x0, x1, x2, _, y0, y1, y2, _, z0, z1, z2, _, t0, t1, t2, _] = columns;
    let axes = DMat3::from_cols(DVec3::new(x0, x1, x2), DVec3::new(y0, y1, y2), DVec3::new(z0, z1, z2));
    DAffine3::from_mat3_translation(axes, DVec3::new(t0, t1, t2))
}

/// A scale, a rotation by a quaternion, whose length does not matter, and a translation, in this order. A quaternion of
/// length 0 does not rotate.
pub(in crate::load) fn scaled_rotated_moved(scale: [f64; 3], rotation: [f64; 4], translation: [f64; 3]) -> DAffine3 {
    let rotation = unit(rotation).unwrap_or(DQuat::IDENTITY);
    DAffine3::from_scale_rotation_translation(DVec3::from_array(scale), rotation, DVec3::from_array(translation))
}

/// The unit quaternion in this direction.
fn unit(rotation: [f64; 4]) -> Option<DQuat> {
    let of_length = |[x, y, z, w]: [f64; 4]| {
        let length = DQuat::from_xyzw(x, y, z, w).length();
        length.is_normal().then(|| DQuat::from_xyzw(x / length, y / length, z / length, w / length))
    };
    // The squares of large or small numbers may leave f64's range.
    let size = rotation.iter().fold(0.0, |size: f64, part| size.max(part.abs()));
    of_length(rotation).or_else(|| of_length(rotation.map(|part| part / size)))
}
