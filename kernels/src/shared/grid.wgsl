// The grid and its cells.

struct Grid {
    // Lower corner of cell (0, 0, 0), traced units.
    corner: vec3f,
    // Cells along each axis.
    cells: vec3i,
    // Halvings of an irregular grid's top-level cells.
    levels: u32,
    // Size of a cell, traced units.
    width: vec3f,
    // 1 / width, rounded.
    inverse_width: vec3f,
}

@group(1) @binding(1) var<uniform> grid: Grid;

fn cell_index(cell: vec3i) -> u32 {
    return u32(cell.x + grid.cells.x * (cell.y + grid.cells.y * cell.z));
}

fn cell_of_index(index: u32) -> vec3i {
    let i = i32(index);
    let row = i / grid.cells.x;
    return vec3i(i % grid.cells.x, row % grid.cells.y, row / grid.cells.y);
}

fn is_in_grid(cell: vec3i) -> bool {
    return all(cell >= vec3i(0)) && all(cell < grid.cells);
}

// The paper's test for a ray that has left: beyond the upper faces the index continues in the next row.
fn is_index_in_range(cell: vec3i) -> bool {
    // In f32 as in the paper, and so without overflow for a cell far away.
    let index = f32(cell.x) + f32(grid.cells.x) * (f32(cell.y) + f32(grid.cells.y) * f32(cell.z));
    let count = f32(grid.cells.x) * f32(grid.cells.y) * f32(grid.cells.z);
    // Beyond 2^24 cells f32 may round index and count to the same number; the integers guard the arrays' end.
    let in_arrays = cell_index(cell) < u32(grid.cells.x * grid.cells.y * grid.cells.z);
    return index < count && all(cell >= vec3i(0)) && in_arrays;
}

// Coordinates of a cell's lower faces, relative to the grid's corner: exact.
fn cell_plane(cell: vec3i) -> vec3f {
    return grid.width * vec3f(cell);
}

fn is_in_cell(position: vec3f, cell: vec3i) -> bool {
    let low = grid.corner + cell_plane(cell);
    return all(position >= low) && all(position <= low + grid.width);
}

// The axis that is crossed next, with ties in the order of Listing 1.
fn smallest_axis(tmax: vec3f) -> vec3<bool> {
    let x = tmax.x < tmax.y && tmax.x < tmax.z;
    let y = !(tmax.x < tmax.y) && tmax.y < tmax.z;
    return vec3<bool>(x, y, !x && !y);
}
