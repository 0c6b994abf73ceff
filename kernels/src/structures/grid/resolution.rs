//! The automatic resolution of a grid.

use super::MAX_CELLS;

/// Cells along each axis for `triangles` triangles in a box of these sides: nearly cubic cells, about
/// [`CELLS_PER_TRIANGLE`] per triangle. An axis thinner than a cell gets one cell, and the other two axes share the
/// rest.
#[must_use]
pub fn automatic_cells(triangles: u64, extent: [f64; 3]) -> [u32; 3] {
    cubes((triangles as f64 * CELLS_PER_TRIANGLE).clamp(1.0, MAX_CELLS as f64 / 4.0), extent)
}

/// About `wanted` nearly cubic cells in a box of these sides.
pub(in crate::structures) fn cubes(wanted: f64, extent: [f64; 3]) -> [u32; 3] {
    let mut flat = [false; 3];
    loop {
        let axes = (0..3).filter(|&a| !flat[a]).count();
        if axes == 0 {
            return [1; 3];
        }
        let volume: f64 = (0..3).filter(|&a| !flat[a]).map(|a| extent[a]).product();
        let width = (volume / wanted).powf(1.0 / axes as f64);
        let thin = (0..3).filter(|&a| !flat[a] && extent[a] <= width * 0.5).collect::<Vec<_>>();
        if !width.is_finite() || width <= 0.0 || !thin.is_empty() {
            // Zero width: at least one side is zero.
            let smallest = (0..3).filter(|&a| !flat[a]).min_by(|&a, &b| extent[a].total_cmp(&extent[b]));
            flat[smallest.unwrap_or(0)] = true;
            continue;
        }
        return [0, 1, 2].map(|a| if flat[a] { 1 } else { (extent[a] / width).round().clamp(1.0, 1024.0) as u32 });
    }
}

/// Cells per triangle that the automatic resolution aims for.
pub const CELLS_PER_TRIANGLE: f64 = 6.0;

/// The same with empty-space skipping, which makes empty cells cheap, so that shorter lists pay off: of 6, 24, 48 and
/// 96 on two scanned meshes, 48 took the least time or at most 10% more.
pub const LEAPING_CELLS_PER_TRIANGLE: f64 = 48.0;

/// Most cells of the automatic resolution with empty-space skipping: 128 MiB of starts.
const MOST_LEAPING_CELLS: f64 = 33_000_000.0;

/// Number of cells to aim for, for this many triangles and empty-space skipping.
pub(super) fn leaping(triangles: u64) -> f64 {
    (triangles as f64 * LEAPING_CELLS_PER_TRIANGLE).clamp(1.0, MOST_LEAPING_CELLS)
}
