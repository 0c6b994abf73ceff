//! Twin of `grid.wgsl`, and of the modules in `grid_walk`: the start of a walk through the grid, and one step, with each
//! of the rules.

mod dda;
mod paper;
mod robust;

use bytemuck::{Pod, Zeroable};

use super::dda::slopes;
use crate::numbers::real::{Real, Vec3};

/// The uniform `grid`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Grid {
    /// Lower corner of cell (0, 0, 0), traced units.
    pub corner: [f32; 3],
    pub(crate) _pad0: u32,
    /// Cells along each axis.
    pub cells: [i32; 3],
    /// Of an irregular grid's virtual grid: its cells along an axis of a top-level cell are 2 to the power of this.
    pub levels: u32,
    /// Size of a cell, traced units.
    pub width: [f32; 3],
    pub(crate) _pad2: u32,
    /// 1 / width, rounded.
    pub inverse_width: [f32; 3],
    pub(crate) _pad3: u32,
}

/// Which of the rules a run uses; the WGSL has them as `@if`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WalkRules {
    /// `--numerics robust`, else `paper`.
    pub robust: bool,
    /// Origins may lie outside of the grid.
    pub clip: bool,
    /// tMax is accumulated: it grows by tDelta per cell. Always so with the paper's rules.
    pub drifting: bool,
    /// `--traversal 3d-dda`; only with the paper's rules.
    pub dda: bool,
}

/// A ray, and the values that each of its steps needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridRay<R> {
    /// Origin, relative to the grid's corner.
    pub origin: Vec3<R>,
    /// Direction.
    pub direction: Vec3<R>,
    /// robust: 1 / direction, 0 along a parallel axis. paper: tDelta, the t between two planes of an axis; with a 3D-DDA,
    /// slopes: cells along the axis per cell along the driving axis.
    pub per_axis: Vec3<R>,
}

/// A ray's position in the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk<R> {
    /// Cell coordinates.
    pub cell: [i32; 3],
    /// tMax: t at which the ray leaves the cell, per axis. With a 3D-DDA, its control terms: how far the ray has gone past
    /// each axis's next face at that of the driving axis, in cells.
    pub per_axis: Vec3<R>,
    /// False if the ray misses the grid or has left it.
    pub inside: bool,
}

impl Grid {
    /// 1-D index, x fastest. Wraps like WGSL if a ray wraps over a face with the paper's numerics.
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

    /// Coordinates of a cell's lower faces.
    pub fn cell_plane<R: Real>(&self, cell: [i32; 3]) -> Vec3<R> {
        Vec3::from_f32(self.corner) + self.relative_plane(cell)
    }

    /// The same relative to the grid's corner: exact.
    pub fn relative_plane<R: Real>(&self, cell: [i32; 3]) -> Vec3<R> {
        Vec3::from_f32(self.width) * Vec3::from(cell.map(R::from_i32))
    }

    /// Whether a point lies in the cell, its faces included.
    pub fn is_in_cell<R: Real>(&self, position: Vec3<R>, cell: [i32; 3]) -> bool {
        let low = self.cell_plane::<R>(cell);
        let high = low + Vec3::from_f32(self.width);
        position.x >= low.x
            && position.y >= low.y
            && position.z >= low.z
            && position.x <= high.x
            && position.y <= high.y
            && position.z <= high.z
    }

    /// Prepares a ray for [`enter`](Self::enter) and [`advance`](Self::advance).
    pub fn ray<R: Real>(&self, rules: WalkRules, origin: Vec3<R>, direction: Vec3<R>) -> GridRay<R> {
        let per_axis = if rules.robust {
            robust::inverse_direction(direction)
        } else if rules.dda {
            slopes(direction, Vec3::from_f32(self.width))
        } else {
            zip(Vec3::from_f32(self.width), direction, |w: R, d| (w / d).abs())
        };
        GridRay { origin: origin - Vec3::from_f32(self.corner), direction, per_axis }
    }

    /// The first cell of a ray.
    pub fn enter<R: Real>(&self, rules: WalkRules, ray: &GridRay<R>) -> Walk<R> {
        match rules {
            WalkRules { robust: true, clip, .. } => self.enter_robust(clip, ray),
            WalkRules { dda: true, .. } => self.enter_dda(ray),
            _ => self.enter_paper(ray),
        }
    }

    /// The next cell of a ray.
    pub fn advance<R: Real>(&self, rules: WalkRules, walk: Walk<R>, ray: &GridRay<R>) -> Walk<R> {
        match rules {
            WalkRules { robust: true, drifting, .. } => self.advance_robust(drifting, walk, ray),
            WalkRules { dda: true, .. } => self.advance_dda(walk, ray),
            _ => self.advance_paper(walk, ray),
        }
    }

    /// The next cell of a ray, or past a cube of empty ones if its size is known: `distance` is that of
    /// [`leap`](Self::leap), 0 in a cell with a list.
    pub fn next_cell<R: Real>(&self, rules: WalkRules, walk: Walk<R>, distance: i32, ray: &GridRay<R>) -> Walk<R> {
        if distance > 1 { self.leap(walk, distance, ray) } else { self.advance(rules, walk, ray) }
    }

    /// The paper's test for a ray that has left: beyond the upper faces the index continues in the next row.
    fn is_index_in_range(&self, cell: [i32; 3]) -> bool {
        // In f32 as in the paper, and so without overflow for a cell far away.
        let ([x, y, z], [nx, ny, nz]) = (cell.map(|c| c as f32), self.cells.map(|c| c as f32));
        let index = x + nx * (y + ny * z);
        // Beyond 2²⁴ cells f32 may round index and count to the same number; the integers guard the arrays' end.
        let in_arrays = self.cell_index(cell) < self.cells.iter().product::<i32>() as u32;
        index < nx * ny * nz && cell.iter().all(|&c| c >= 0) && in_arrays
    }
}

/// The axis that is crossed next, with ties in the order of the paper's Listing 1.
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
