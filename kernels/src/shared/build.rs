//! Twin of `build.wgsl`: the input of a grid build.

use bytemuck::{Pod, Zeroable};

use super::grid_walk::Grid;

/// The uniform `build`. The WGSL reads its floats as bits.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Build {
    /// Lower corner of cell (0, 0, 0).
    pub corner: [f32; 3],
    /// Growth of cells on all sides.
    pub growth: f32,
    /// Size of a cell.
    pub width: [f32; 3],
    /// Number of triangles.
    pub triangles: u32,
    /// Cells along each axis; of an irregular grid, those of its top level, as above.
    pub cells: [u32; 3],
    /// Most halvings of such a cell.
    pub levels: u32,
    /// Proportions of a cell's sides, at most 255.
    pub weights: [u32; 3],
    /// Whether cells are divided as their content asks for, else only crowded ones.
    pub by_content: u32,
}

impl Build {
    /// The uniform for building the lists of `grid`.
    #[must_use]
    pub fn new(grid: &Grid, growth: f32, triangles: u32) -> Self {
        let cells = grid.cells.map(|n| n as u32);
        Self { corner: grid.corner, growth, width: grid.width, triangles, cells, ..Self::default() }
    }
}
