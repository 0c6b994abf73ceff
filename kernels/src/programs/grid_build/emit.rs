//! CPU reference of `emit.wgsl`.

use super::span::Span;

/// Writes a reference for each cell that a span overlaps, x ascending; `cells` are the grid's along each axis.
pub fn emit(span: &Span, first_reference: u32, cells: [u32; 3], cell_out: &mut [u32], triangle_out: &mut [u32]) {
    let [x, y, z] = span.cells_at;
    let first = x + cells[0] * (y + cells[1] * z);
    let mut left = span.mask;
    let mut reference = first_reference as usize;
    while left != 0 {
        cell_out[reference] = first + left.trailing_zeros();
        triangle_out[reference] = span.triangle;
        left &= left - 1;
        reference += 1;
    }
}
