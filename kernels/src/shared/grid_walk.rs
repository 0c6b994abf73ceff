//! Twin of `grid_walk.wgsl`: where a walk through the grid starts, and one step.

use bytemuck::{Pod, Zeroable};

use super::constants::{INF, PAPER_PARALLEL, PARALLEL};
use super::vector::smallest3;
use crate::real::{Real, Vec3};

/// The uniform `grid`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Grid {
    /// Lower corner of cell (0, 0, 0), traced units.
    pub corner: [f32; 3],
    pub(crate) _pad0: u32,
    /// Cells along each axis.
    pub cells: [i32; 3],
    pub(crate) _pad1: u32,
    /// Size of a cell, traced units.
    pub width: [f32; 3],
    pub(crate) _pad2: u32,
    /// 1 / width, rounded.
    pub inverse_width: [f32; 3],
    pub(crate) _pad3: u32,
}

/// What part of the rules a run uses; the WGSL has them as `@if`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WalkRules {
    /// `--numerics robust`, else `paper`.
    pub robust: bool,
    /// Origins may lie outside of the grid.
    pub clip: bool,
}

/// A ray's place in the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk<R> {
    /// Cell coordinates.
    pub cell: [i32; 3],
    /// t at which the ray leaves the cell, per axis.
    pub tmax: Vec3<R>,
    /// False where the ray misses or has left the grid.
    pub inside: bool,
}

impl Grid {
    /// 1-D index, x fastest. Wraps as WGSL does where the paper's numerics run over a face.
    #[must_use]
    pub fn cell_index(&self, cell: [i32; 3]) -> u32 {
        let row = cell[1].wrapping_add(self.cells[1].wrapping_mul(cell[2]));
        cell[0].wrapping_add(self.cells[0].wrapping_mul(row)) as u32
    }

    /// Cell coordinates of a 1-D index.
    #[must_use]
    pub fn cell_of_index(&self, index: u32) -> [i32; 3] {
        let i = index as i32;
        let row = i / self.cells[0];
        [i % self.cells[0], row % self.cells[1], row / self.cells[1]]
    }

    /// Whether the grid has this cell.
    #[must_use]
    pub fn is_in_grid(&self, cell: [i32; 3]) -> bool {
        (0..3).all(|a| cell[a] >= 0 && cell[a] < self.cells[a])
    }

    /// Lower faces of a cell.
    pub fn cell_plane<R: Real>(&self, cell: [i32; 3]) -> Vec3<R> {
        Vec3::from_f32(self.corner) + Vec3::from_f32(self.width) * Vec3::from(cell.map(R::from_i32))
    }

    /// t at which the ray leaves the cell, per axis.
    fn cell_exit<R: Real>(&self, cell: [i32; 3], origin: Vec3<R>, inverse: Vec3<R>) -> Vec3<R> {
        let ahead = inverse.map(|v| i32::from(v > R::zero())).to_array();
        let t = (self.cell_plane::<R>(add(cell, ahead)) - origin) * inverse;
        select(t, Vec3::splat(R::from_f32(INF)), inverse.map(|v| v == R::zero()))
    }

    /// The first cell of a ray.
    pub fn enter<R: Real>(&self, rules: WalkRules, origin: Vec3<R>, direction: Vec3<R>) -> Walk<R> {
        if rules.robust {
            self.enter_robust(rules.clip, origin, direction)
        } else {
            self.enter_paper(origin, direction)
        }
    }

    /// The next cell of a ray.
    pub fn advance<R: Real>(&self, rules: WalkRules, walk: Walk<R>, origin: Vec3<R>, direction: Vec3<R>) -> Walk<R> {
        if rules.robust { self.advance_robust(walk, origin, direction) } else { self.advance_paper(walk, direction) }
    }

    fn enter_robust<R: Real>(&self, clip: bool, origin: Vec3<R>, direction: Vec3<R>) -> Walk<R> {
        let inverse = inverse_direction(direction);
        let (mut start, mut inside) = (origin, true);
        if clip {
            let near_plane = self.cell_plane::<R>([0; 3]);
            let far_plane = self.cell_plane::<R>(self.cells);
            let t0 = (near_plane - origin) * inverse;
            let t1 = (far_plane - origin) * inverse;
            // A parallel axis does not bound t: inside its slab always, outside never.
            let parallel = inverse.map(|v| v == R::zero());
            let outside = |p: bool, o: R, near: R, far: R| p && (o < near || o > far);
            let enter = select(zip(t0, t1, R::min), Vec3::splat(R::zero()), parallel);
            let leave = select(zip(t0, t1, R::max), Vec3::splat(R::from_f32(INF)), parallel);
            let t_enter = enter.x.max(enter.y).max(enter.z.max(R::zero()));
            let t_leave = smallest3(leave);
            start = origin + direction * t_enter;
            // The negated comparison sends NaN outside.
            inside = t_enter <= t_leave
                && !outside(parallel.x, origin.x, near_plane.x, far_plane.x)
                && !outside(parallel.y, origin.y, near_plane.y, far_plane.y)
                && !outside(parallel.z, origin.z, near_plane.z, far_plane.z);
        }
        let position = (start - Vec3::from_f32(self.corner)) * Vec3::from_f32(self.inverse_width);
        let cell = position.map(|v| v.floor().to_i32()).to_array();
        let cell = [0, 1, 2].map(|a| cell[a].max(0).min(self.cells[a] - 1));
        Walk { cell, tmax: self.cell_exit(cell, origin, inverse), inside }
    }

    fn advance_robust<R: Real>(&self, walk: Walk<R>, origin: Vec3<R>, direction: Vec3<R>) -> Walk<R> {
        let inverse = inverse_direction(direction);
        let axis = smallest_axis(walk.tmax);
        let forward = inverse.map(|v| if v > R::zero() { 1 } else { -1 }).to_array();
        let cell = add(walk.cell, [0, 1, 2].map(|a| if axis[a] { forward[a] } else { 0 }));
        let crossed = smallest3(walk.tmax) < R::from_f32(INF);
        Walk { cell, tmax: self.cell_exit(cell, origin, inverse), inside: crossed && self.is_in_grid(cell) }
    }

    fn enter_paper<R: Real>(&self, origin: Vec3<R>, direction: Vec3<R>) -> Walk<R> {
        // The paper's origin is relative to the grid's.
        let relative = origin - Vec3::from_f32(self.corner);
        let width = Vec3::<R>::from_f32(self.width);
        let cell = zip(relative, width, |o, w| o / w).map(|v| v.floor().to_i32()).to_array();
        let two = R::from_f32(2.0);
        let plane = Vec3::from(cell.map(R::from_i32)) * width
            + (direction.map(|d| R::one() + sign(d)) * width).map(|v| v / two);
        let parallel = direction.abs().map(|v| v < R::from_f32(PAPER_PARALLEL));
        let t = zip(plane - relative, select(direction, Vec3::splat(R::one()), parallel), |p, d| p / d);
        // An origin outside of the grid is not handled; only an index outside of the arrays is refused.
        let tmax = select(t, Vec3::splat(R::from_f32(INF)), parallel);
        Walk { cell, tmax, inside: self.is_index_in_range(cell) }
    }

    fn advance_paper<R: Real>(&self, walk: Walk<R>, direction: Vec3<R>) -> Walk<R> {
        let t_delta = zip(Vec3::from_f32(self.width), direction, |w: R, d| (w / d).abs());
        let axis = smallest_axis(walk.tmax);
        let forward = direction.map(|d| sign(d).to_i32()).to_array();
        let cell = add(walk.cell, [0, 1, 2].map(|a| if axis[a] { forward[a] } else { 0 }));
        let tmax = select(walk.tmax, walk.tmax + t_delta, axis.into());
        Walk { cell, tmax, inside: self.is_index_in_range(cell) }
    }

    /// The paper's test for a ray that has left: on the + faces the index runs on into the next row.
    fn is_index_in_range(&self, cell: [i32; 3]) -> bool {
        // In f32 as in the paper, and so without overflow for a cell far away.
        let ([x, y, z], [nx, ny, nz]) = (cell.map(|c| c as f32), self.cells.map(|c| c as f32));
        let index = x + nx * (y + ny * z);
        // Beyond 2²⁴ cells f32 rounds the two together; the integers keep the arrays' end.
        let in_arrays = self.cell_index(cell) < self.cells.iter().product::<i32>() as u32;
        index < nx * ny * nz && cell.iter().all(|&c| c >= 0) && in_arrays
    }
}

/// 1 / direction; 0 along a parallel axis.
fn inverse_direction<R: Real>(direction: Vec3<R>) -> Vec3<R> {
    direction.map(|d| if d.abs() < R::from_f32(PARALLEL) { R::zero() } else { R::one() / d })
}

/// Which axis is crossed next, in the order of the paper's Listing 1.
pub fn smallest_axis<R: Real>(tmax: Vec3<R>) -> [bool; 3] {
    let x = tmax.x < tmax.y && tmax.x < tmax.z;
    #[allow(clippy::neg_cmp_op_on_partial_ord, reason = "as the WGSL has it: NaN is not smaller")]
    let y = !(tmax.x < tmax.y) && tmax.y < tmax.z;
    [x, y, !x && !y]
}

fn add(a: [i32; 3], b: [i32; 3]) -> [i32; 3] {
    [0, 1, 2].map(|i| a[i].wrapping_add(b[i]))
}

fn sign<R: Real>(v: R) -> R {
    if v > R::zero() {
        R::one()
    } else if v < R::zero() {
        -R::one()
    } else {
        R::zero()
    }
}

fn select<R: Real>(no: Vec3<R>, yes: Vec3<R>, pick: Vec3<bool>) -> Vec3<R> {
    Vec3::new(if pick.x { yes.x } else { no.x }, if pick.y { yes.y } else { no.y }, if pick.z { yes.z } else { no.z })
}

fn zip<R: Real>(a: Vec3<R>, b: Vec3<R>, f: impl Fn(R, R) -> R) -> Vec3<R> {
    Vec3::new(f(a.x, b.x), f(a.y, b.y), f(a.z, b.z))
}
