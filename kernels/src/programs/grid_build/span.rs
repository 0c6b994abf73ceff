//! CPU reference of `span.wgsl` and `overlap.wgsl`.

use super::bound::CellBox;
use crate::shared::grid_walk::Grid;
use crate::structures::grid::overlap::Overlap;

/// Up to 32 cells along x, in one row of a triangle's box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// The triangle.
    pub triangle: u32,
    /// Its first cell.
    pub cells_at: [u32; 3],
    /// One bit per cell that the triangle overlaps; the lowest bit is the first cell.
    pub mask: u32,
}

/// The triangle of a span: the last one whose spans begin at or before it. Each has at least one.
fn triangle_of(span: u32, first_span: &[u32]) -> usize {
    let (mut low, mut high) = (0, first_span.len());
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if first_span[middle] <= span {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Tests the cells of span `i`. `first_span` holds the prefix sums of the numbers of spans, one per triangle, like
/// `boxes`.
#[must_use]
pub fn span(i: u32, first_span: &[u32], boxes: &[CellBox], grid: &Grid, growth: f32, vertices: &[f32]) -> Span {
    let t = triangle_of(i, first_span);
    // If somebody has edited a box, the result may be anything, but there must be no panic.
    let Some(&CellBox { low, high }) = boxes.get(t) else { return Span::default() };
    let spans_a_row = (high[0].wrapping_sub(low[0]).wrapping_add(32) / 32).max(1);
    let within = i.wrapping_sub(first_span[t]);
    let row = within / spans_a_row;
    let rows = high[1].wrapping_sub(low[1]).wrapping_add(1).max(1);
    let along = [32 * (within % spans_a_row), row % rows, row / rows];
    let first = [0, 1, 2].map(|a| low[a].wrapping_add(along[a]));

    let mask = if low == high {
        // The only cell it can be in.
        1
    } else {
        let overlap = Overlap::new(grid, f64::from(growth), &vertices[9 * t..9 * t + 9]);
        let last = first[0].saturating_add(31).min(high[0]);
        overlap.span_mask(first.map(|n| n as i32), last.wrapping_sub(first[0]).wrapping_add(1))
    };
    Span { triangle: t as u32, cells_at: first, mask }
}
