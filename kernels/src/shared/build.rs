//! Twin of `build.wgsl`: the input of a grid build.

use bytemuck::{Pod, Zeroable};

use super::grid_walk::Grid;
use crate::numbers::units::exp2;

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
    /// [`BY_CONTENT`], and for each axis whether all planes and centres of cells are exact in f32.
    pub flags: u32,
}

/// Bit of [`Build::flags`]: cells are divided as their content asks for, else only crowded ones.
pub const BY_CONTENT: u32 = 1;

impl Build {
    /// The uniform for building the lists of `grid`.
    #[must_use]
    pub fn new(grid: &Grid, growth: f32, triangles: u32) -> Self {
        let cells = grid.cells.map(|n| n as u32);
        let flags = exact_axes(grid);
        Self { corner: grid.corner, growth, width: grid.width, triangles, cells, flags, ..Self::default() }
    }

    /// Whether cells are divided as their content asks for.
    #[must_use]
    pub fn by_content(&self) -> bool {
        self.flags & BY_CONTENT != 0
    }
}

/// The bits of [`Build::flags`] for the axes along which all planes and centres of cells are exact in f32.
pub(crate) fn exact_axes(grid: &Grid) -> u32 {
    let is_exact = |a: usize| {
        let (corner, half) = (f64::from(grid.corner[a]), f64::from(grid.width[a]) / 2.0);
        let end = corner + f64::from(2 * grid.cells[a]) * half;
        let unit = lowest_bit(corner).min(lowest_bit(half));
        unit >= f64::from(f32::MIN_POSITIVE) && corner.abs().max(end.abs()) <= unit * (1 << 24) as f64
    };
    (0..3).filter(|&a| is_exact(a)).map(|a| 2 << a).sum()
}

/// The largest power of two of which a number is a multiple.
fn lowest_bit(v: f64) -> f64 {
    let bits = v.to_bits();
    let (exponent, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
    match (exponent, fraction) {
        (0, 0) => f64::INFINITY,
        // Far below what f32 holds.
        (0, _) => 0.0,
        (_, 0) => exp2(exponent - 1023),
        _ => exp2(exponent - 1023 - 52 + fraction.trailing_zeros() as i32),
    }
}
