//! CPU reference of `emit.wgsl`.

use super::span::Span;

/// Writes a reference for each cell that a span overlaps, x ascending; `cells` are the numbers of the grid's cells per
/// axis.
pub fn emit(span: &Span, first_reference: u32, cells: [u32; 3], cell_out: &mut [u32], triangle_out: &mut [u32]) {
    let [x, y, z] = span.cells_at;
    let first = x.wrapping_add(cells[0].wrapping_mul(y.wrapping_add(cells[1].wrapping_mul(z))));
    let mut left = span.mask;
    let mut reference = first_reference as usize;
    while left != 0 {
        // If somebody has edited the streams, writes outside of them are ignored, as on a device.
        if let (Some(cell), Some(triangle)) = (cell_out.get_mut(reference), triangle_out.get_mut(reference)) {
            (*cell, *triangle) = (first.wrapping_add(left.trailing_zeros()), span.triangle);
        }
        left &= left - 1;
        reference += 1;
    }
}
