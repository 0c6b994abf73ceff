//! CPU reference of `bound.wgsl`.

use crate::shared::grid_walk::Grid;
use crate::structures::grid::overlap::Overlap;

/// First and last cell that a triangle's bounding box touches, per axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellBox {
    /// First cell.
    pub low: [u32; 3],
    /// Last cell.
    pub high: [u32; 3],
}

/// The cells of a triangle's bounding box, and its number of spans: at most 2³¹, as an axis has at most 4096 cells.
#[must_use]
pub fn bound(triangle: &[f32], grid: &Grid, growth: f32) -> (CellBox, u32) {
    let overlap = Overlap::new(grid, f64::from(growth), triangle);
    let (low, high) = (overlap.low.map(|n| n as u32), overlap.high.map(|n| n as u32));
    let cells = [0, 1, 2].map(|a| high[a] - low[a] + 1);
    (CellBox { low, high }, cells[0].div_ceil(32) * cells[1] * cells[2])
}
