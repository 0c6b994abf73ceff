// The input of a grid build. Floats are loaded as their bits: a device may flush a subnormal that is loaded as f32.

struct Build {
    // Lower corner of cell (0, 0, 0), f32 bits.
    corner: vec3u,
    // Growth of cells on all sides, f32 bits.
    growth: u32,
    // Size of a cell, f32 bits.
    width: vec3u,
    triangles: u32,
    // Cells along each axis; of an irregular grid, those of its top level, as above.
    cells: vec3u,
    // Most halvings of such a cell.
    levels: u32,
    // Proportions of a cell's sides, at most 255.
    weights: vec3u,
    // Bit 0: cells are divided as their content asks for, else only crowded ones. Bits 1 to 3: all planes and centres of an
    // axis are exact in f32.
    flags: u32,
}

@group(1) @binding(0) var<uniform> build: Build;
// Nine words per triangle, f32 bits.
@group(1) @binding(1) var<storage, read> vertices: array<u32>;
