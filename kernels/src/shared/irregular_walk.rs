//! Twin of `irregular_walk.wgsl`: the walk through the irregular grid.

use bytemuck::{Pod, Zeroable};

use super::constants::{INF, OUTSIDE};
use super::grid_walk::{Grid, GridRay, WalkRules, smallest_axis};
use super::vector::smallest3;
use crate::numbers::real::{Real, Vec3};

/// A cell: its expanded box in virtual cells, and its list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct IrregularCell {
    /// First virtual cell along each axis.
    pub low: [u16; 3],
    /// The one after the last.
    pub high: [u16; 3],
    /// Start of its list, or [`NO_LIST`](super::constants::NO_LIST).
    pub first: u32,
}

/// An entry of the voxel map for a cell: its index above bits 0 and 1, which are 0.
#[must_use]
pub const fn cell_entry(cell: u32) -> u32 {
    cell << 2
}

/// An entry of the voxel map for a block of finer ones: where it starts, and in bits 0 and 1 the levels that it covers, 1
/// to 3. A block has 8 to the power of its levels, x fastest.
#[must_use]
pub const fn block_entry(start: u32, levels: u32) -> u32 {
    start << 2 | levels
}

impl IrregularCell {
    /// The corners of its box.
    #[must_use]
    pub fn corners(&self) -> [[i32; 3]; 2] {
        [self.low, self.high].map(|corner| corner.map(i32::from))
    }

    /// t at which the ray leaves the box, per axis.
    pub fn exit<R: Real>(&self, grid: &Grid, ray: &GridRay<R>) -> Vec3<R> {
        let [low, high] = self.corners();
        let inverse = ray.per_axis;
        let is_up = inverse.map(|v| v > R::zero()).to_array();
        let ahead = [0, 1, 2].map(|a| if is_up[a] { high[a] } else { low[a] });
        let t = ((grid.relative_plane::<R>(ahead) - ray.origin) * inverse).to_array();
        let inverse = inverse.to_array();
        Vec3::from([0, 1, 2].map(|a| if inverse[a] == R::zero() { R::from_f32(INF) } else { t[a] }))
    }

    /// The virtual cell behind the face by which the ray leaves the box, whose exits are given; `None` if that is the
    /// grid's end. Along the other axes it is where the ray is at this t, but neither outside of the box nor before
    /// `voxel`, the virtual cell in which the ray came: rounding cannot move it there.
    pub fn next<R: Real>(&self, grid: &Grid, voxel: [i32; 3], exit: Vec3<R>, ray: &GridRay<R>) -> Option<[i32; 3]> {
        let [low, high] = self.corners();
        let axis = smallest_axis(exit);
        let t = smallest3(exit);
        let position = (ray.origin + ray.direction * Vec3::splat(t)) * Vec3::from_f32(grid.inverse_width);
        let position = position.to_array().map(R::rounded_down);
        let is_up = ray.per_axis.map(|v| v > R::zero()).to_array();
        let next = [0, 1, 2].map(|a| match (axis[a], is_up[a]) {
            (true, true) => high[a],
            (true, false) => low[a] - 1,
            (false, true) => position[a].clamp(voxel[a], high[a] - 1),
            (false, false) => position[a].clamp(low[a], voxel[a]),
        });
        (t < R::from_f32(INF) && grid.is_in_grid(next)).then_some(next)
    }
}

/// A ray's position in the irregular grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VoxelWalk {
    /// The virtual cell by which it came.
    pub voxel: [i32; 3],
    /// The cell.
    pub cell: u32,
    /// False if the ray misses the grid or has left it.
    pub inside: bool,
}

/// What a walk needs of an irregular grid.
#[derive(Clone, Copy, Debug)]
pub struct Irregular<'a> {
    /// The virtual grid.
    pub grid: &'a Grid,
    /// The voxel map.
    pub map: &'a [u32],
    /// The cells.
    pub cells: &'a [IrregularCell],
    /// Whether triangles were set aside: rays begin in the space around the grid, [`OUTSIDE`], which lists them.
    pub has_aside: bool,
}

impl Irregular<'_> {
    /// t at which a ray leaves its cell's box, per axis.
    pub fn exit<R: Real>(&self, walk: &VoxelWalk, ray: &GridRay<R>) -> Vec3<R> {
        match self.has_aside && walk.cell == OUTSIDE {
            true => Vec3::splat(self.reached(ray)),
            false => self.cells[walk.cell as usize].exit(self.grid, ray),
        }
    }

    /// t at which a ray leaves the space around the grid: it enters the grid, or never does.
    fn reached<R: Real>(&self, ray: &GridRay<R>) -> R {
        let (t, meets) = self.grid.clipped(ray);
        if meets { t } else { R::from_f32(INF) }
    }

    /// The first cell of a ray.
    pub fn enter<R: Real>(&self, rules: WalkRules, ray: &GridRay<R>) -> VoxelWalk {
        match self.has_aside {
            true => VoxelWalk { voxel: [0; 3], cell: OUTSIDE, inside: true },
            false => self.enter_grid(rules, ray),
        }
    }

    /// The first cell of a ray in the grid.
    fn enter_grid<R: Real>(&self, rules: WalkRules, ray: &GridRay<R>) -> VoxelWalk {
        let walk = self.grid.enter(rules, ray);
        VoxelWalk { voxel: walk.cell, cell: find(self.grid, self.map, walk.cell), inside: walk.inside }
    }

    /// The next cell; `exit` is where the ray leaves this one's box.
    pub fn step<R: Real>(&self, walk: &VoxelWalk, exit: Vec3<R>, ray: &GridRay<R>) -> VoxelWalk {
        if self.has_aside && walk.cell == OUTSIDE {
            return self.enter_grid(WalkRules { robust: true, clip: true, drifting: false, dda: false }, ray);
        }
        match self.cells[walk.cell as usize].next(self.grid, walk.voxel, exit, ray) {
            Some(voxel) => VoxelWalk { voxel, cell: find(self.grid, self.map, voxel), inside: true },
            None => VoxelWalk { inside: false, ..*walk },
        }
    }
}

/// The cell to which a virtual cell of the grid belongs.
#[must_use]
pub fn find(grid: &Grid, map: &[u32], voxel: [i32; 3]) -> u32 {
    let voxel = voxel.map(|v| v as u32);
    let mut shift = grid.levels;
    let (top, size) = (voxel.map(|v| v >> shift), grid.cells.map(|n| n as u32 >> shift));
    let mut entry = map[(top[0] + size[0] * (top[1] + size[1] * top[2])) as usize];
    while entry & 3 != 0 {
        let depth = entry & 3;
        shift -= depth;
        let at = voxel.map(|v| v >> shift & ((1 << depth) - 1));
        entry = map[((entry >> 2) + at[0] + ((at[1] + (at[2] << depth)) << depth)) as usize];
    }
    entry >> 2
}
