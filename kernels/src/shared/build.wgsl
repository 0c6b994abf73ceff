// The input of a grid build. Floats are loaded as their bits: a device may flush a subnormal that is loaded as f32.

struct Build {
    // Lower corner of cell (0, 0, 0), f32 bits.
    corner: vec3u,
    // Growth of cells on all sides, f32 bits.
    growth: u32,
    // Size of a cell, f32 bits.
    width: vec3u,
    triangles: u32,
    // Cells along each axis.
    cells: vec3u,
    _pad: u32,
}

@group(1) @binding(0) var<uniform> build: Build;
// Nine words per triangle, f32 bits.
@group(1) @binding(1) var<storage, read> vertices: array<u32>;
