//! Twin of `dda.wgsl`: the walk as a 3D-DDA.

use super::{Grid, GridRay, Walk, add, sign, zip};
use crate::numbers::real::{Real, Vec3};
use crate::shared::dda;

impl Grid {
    pub(super) fn enter_dda<R: Real>(&self, ray: &GridRay<R>) -> Walk<R> {
        let position = zip(ray.origin, Vec3::<R>::from_f32(self.width), |o, w| o / w);
        let cell = position.map(|v| v.floor().to_i32()).to_array();
        let per_axis = dda::first_control(position, cell, ray.direction, ray.per_axis);
        Walk { cell, per_axis, inside: self.is_index_in_range(cell) }
    }

    pub(super) fn advance_dda<R: Real>(&self, walk: Walk<R>, ray: &GridRay<R>) -> Walk<R> {
        let axis = dda::crossed_axis(walk.per_axis, ray.per_axis);
        let forward = ray.direction.map(|d| sign(d).to_i32()).to_array();
        let cell = add(walk.cell, [0, 1, 2].map(|a| if axis[a] { forward[a] } else { 0 }));
        let per_axis = dda::next_control(walk.per_axis, ray.per_axis, axis);
        Walk { cell, per_axis, inside: self.is_index_in_range(cell) }
    }
}
