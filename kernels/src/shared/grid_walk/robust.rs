//! Twin of `robust.wgsl`: the walk with robust rules.

use super::{Grid, GridRay, Walk, add, select, smallest_axis, zip};
use crate::numbers::real::{Real, Vec3};
use crate::shared::constants::{INF, PARALLEL};
use crate::shared::vector::smallest3;

/// 1 / direction; 0 along a parallel axis.
pub(super) fn inverse_direction<R: Real>(direction: Vec3<R>) -> Vec3<R> {
    direction.map(|d| if d.abs() < R::from_f32(PARALLEL) { R::zero() } else { R::one() / d })
}

impl Grid {
    /// t at which the ray leaves the cell, per axis.
    pub fn cell_exit<R: Real>(&self, cell: [i32; 3], ray: &GridRay<R>) -> Vec3<R> {
        let inverse = ray.per_axis;
        let ahead = inverse.map(|v| i32::from(v > R::zero())).to_array();
        let t = (self.relative_plane::<R>(add(cell, ahead)) - ray.origin) * inverse;
        select(t, Vec3::splat(R::from_f32(INF)), inverse.map(|v| v == R::zero()))
    }

    /// t at which a ray enters the grid's box, 0 if it starts inside, and whether it meets the box at all.
    pub fn clipped<R: Real>(&self, ray: &GridRay<R>) -> (R, bool) {
        let (origin, inverse) = (ray.origin, ray.per_axis);
        let near_plane = self.relative_plane::<R>([0; 3]);
        let far_plane = self.relative_plane::<R>(self.cells);
        let t0 = (near_plane - origin) * inverse;
        let t1 = (far_plane - origin) * inverse;
        // A parallel axis does not bound t: the ray is inside its slab always or never.
        let parallel = inverse.map(|v| v == R::zero());
        let outside = |p: bool, o: R, near: R, far: R| p && (o < near || o > far);
        let enter = select(zip(t0, t1, R::min), Vec3::splat(R::zero()), parallel);
        let leave = select(zip(t0, t1, R::max), Vec3::splat(R::from_f32(INF)), parallel);
        let t_enter = enter.x.max(enter.y).max(enter.z.max(R::zero()));
        let t_leave = smallest3(leave);
        // The negated comparison treats NaN as outside.
        let meets = t_enter <= t_leave
            && !outside(parallel.x, origin.x, near_plane.x, far_plane.x)
            && !outside(parallel.y, origin.y, near_plane.y, far_plane.y)
            && !outside(parallel.z, origin.z, near_plane.z, far_plane.z);
        (t_enter, meets)
    }

    pub(super) fn enter_robust<R: Real>(&self, clip: bool, ray: &GridRay<R>) -> Walk<R> {
        let (mut start, mut inside) = (ray.origin, true);
        if clip {
            let (t_enter, meets) = self.clipped(ray);
            start = ray.origin + ray.direction * t_enter;
            inside = meets;
        }
        let cell = self.cell_of_position(start);
        let cell = [0, 1, 2].map(|a| cell[a].max(0).min(self.cells[a] - 1));
        Walk { cell, per_axis: self.cell_exit(cell, ray), inside }
    }

    fn cell_of_position<R: Real>(&self, position: Vec3<R>) -> [i32; 3] {
        let position = position * Vec3::from_f32(self.inverse_width);
        position.map(|v| v.floor().to_i32()).to_array()
    }

    pub(super) fn advance_robust<R: Real>(&self, drifting: bool, walk: Walk<R>, ray: &GridRay<R>) -> Walk<R> {
        let axis = smallest_axis(walk.per_axis);
        let forward = forward(ray);
        let cell = add(walk.cell, [0, 1, 2].map(|a| if axis[a] { forward[a] } else { 0 }));
        let crossed = smallest3(walk.per_axis) < R::from_f32(INF);
        let tmax = if drifting {
            let t_delta = (Vec3::from_f32(self.width) * ray.per_axis).abs();
            select(walk.per_axis, walk.per_axis + t_delta, axis.into())
        } else {
            self.cell_exit(cell, ray)
        };
        Walk { cell, per_axis: tmax, inside: crossed && self.is_in_grid(cell) }
    }

    /// Leaves a cube of empty cells at once: every cell that is fewer than `distance` cells away along each axis is
    /// empty (proximity clouds, Cohen and Sheffer, 1994). A leap of distance 1 is a step. robust only.
    pub fn leap<R: Real>(&self, walk: Walk<R>, distance: i32, ray: &GridRay<R>) -> Walk<R> {
        let forward = forward(ray);
        let last = add(walk.cell, forward.map(|f| f * (distance - 1)));
        let exit = self.cell_exit(last, ray);
        let axis = smallest_axis(exit);
        let t = smallest3(exit);
        // As where the ray entered the grid; clamped, so that rounding cannot move it out of the cube or backwards.
        let place = self.cell_of_position(ray.origin + ray.direction * t);
        let cell = [0, 1, 2].map(|a| {
            let (low, high) = (walk.cell[a].min(last[a]), walk.cell[a].max(last[a]));
            if axis[a] { last[a] + forward[a] } else { place[a].max(low).min(high) }
        });
        Walk { cell, per_axis: self.cell_exit(cell, ray), inside: t < R::from_f32(INF) && self.is_in_grid(cell) }
    }
}

/// Direction of a robust ray through the cells, per axis.
fn forward<R: Real>(ray: &GridRay<R>) -> [i32; 3] {
    ray.per_axis.map(|v| if v > R::zero() { 1 } else { -1 }).to_array()
}
