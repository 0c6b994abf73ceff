//! CPU reference of `mark.wgsl`.

/// Finds where the sorted references to each cell begin and end. Cells without references keep 0 and 0.
pub fn mark(cell_in: &[u32], begin: &mut [u32], end: &mut [u32]) {
    for (i, &cell) in cell_in.iter().enumerate() {
        if i == 0 || cell_in[i - 1] != cell {
            write(begin, cell, i as u32);
        }
        if i + 1 == cell_in.len() || cell_in[i + 1] != cell {
            write(end, cell, i as u32 + 1);
        }
    }
}

/// Ignores cells that do not exist: somebody may have edited the stream.
fn write(values: &mut [u32], cell: u32, value: u32) {
    if let Some(of_cell) = values.get_mut(cell as usize) {
        *of_cell = value;
    }
}
