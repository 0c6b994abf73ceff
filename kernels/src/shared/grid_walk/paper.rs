//! Twin of `paper.wgsl`: the walk as in the paper's Listing 1.

use super::{Grid, GridRay, Walk, add, select, sign, smallest_axis, zip};
use crate::numbers::real::{Real, Vec3};
use crate::shared::constants::{INF, PAPER_PARALLEL};

impl Grid {
    pub(super) fn enter_paper<R: Real>(&self, ray: &GridRay<R>) -> Walk<R> {
        let direction = ray.direction;
        let width = Vec3::<R>::from_f32(self.width);
        let cell = zip(ray.origin, width, |o, w| o / w).map(|v| v.floor().to_i32()).to_array();
        let two = R::from_f32(2.0);
        let plane = Vec3::from(cell.map(R::from_i32)) * width
            + (direction.map(|d| R::one() + sign(d)) * width).map(|v| v / two);
        let parallel = direction.abs().map(|v| v < R::from_f32(PAPER_PARALLEL));
        let t = zip(plane - ray.origin, select(direction, Vec3::splat(R::one()), parallel), |p, d| p / d);
        // Origins outside of the grid are not handled; only an index outside of the arrays is rejected.
        let tmax = select(t, Vec3::splat(R::from_f32(INF)), parallel);
        Walk { cell, per_axis: tmax, inside: self.is_index_in_range(cell) }
    }

    pub(super) fn advance_paper<R: Real>(&self, walk: Walk<R>, ray: &GridRay<R>) -> Walk<R> {
        let axis = smallest_axis(walk.per_axis);
        let forward = ray.direction.map(|d| sign(d).to_i32()).to_array();
        let cell = add(walk.cell, [0, 1, 2].map(|a| if axis[a] { forward[a] } else { 0 }));
        let tmax = select(walk.per_axis, walk.per_axis + ray.per_axis, axis.into());
        Walk { cell, per_axis: tmax, inside: self.is_index_in_range(cell) }
    }
}
