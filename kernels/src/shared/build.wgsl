// What the grid is built of. Floats are loaded as their bits: a device may flush a subnormal f32 that it loads as one.

struct Build {
    // Lower corner of cell (0, 0, 0), f32 bits.
    corner: vec3u,
    // What cells are grown by on all sides, f32 bits.
    growth: u32,
    // Size of a cell, f32 bits.
    width: vec3u,
    triangles: u32,
    // Cells along each axis.
    cells: vec3u,
    _pad: u32,
}

@group(1) @binding(0) var<uniform> build: Build;
// Nine words a triangle, f32 bits.
@group(1) @binding(1) var<storage, read> vertices: array<u32>;
