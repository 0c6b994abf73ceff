//! Every buffer of scene data and every uniform, in one table. Per-ray data is in [`crate::tables::stream`].

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferInfo {
    /// Its name in WGSL, files and reports.
    pub name: &'static str,
    /// A uniform, else read-only storage.
    pub is_uniform: bool,
    /// What an element is, with its unit.
    pub element: &'static str,
}

const fn uniform(name: &'static str, element: &'static str) -> BufferInfo {
    BufferInfo { name, is_uniform: true, element }
}

const fn storage(name: &'static str, element: &'static str) -> BufferInfo {
    BufferInfo { name, is_uniform: false, element }
}

/// Every buffer.
pub const BUFFERS: &[BufferInfo] = &[
    uniform("camera", "eye, view plane, pixel size; traced units"),
    uniform("grid", "corner, cells, cell width; traced units"),
    uniform("scene", "triangles, steps a pass, rays, first row of workgroups"),
    uniform("shading", "background, number of lights"),
    uniform("sampling", "samples a pixel, seed"),
    storage("vertices", "nine f32 a triangle: corners 0, 1, 2, traced units"),
    storage("grid_cells", "u32 a cell and one more: start of its list in grid_items"),
    storage("grid_items", "u32 triangle ids, ascending within a cell"),
    storage("grid_distances", "u8 a cell: chessboard distance to the next cell with a list, 0 for one with a list"),
    storage("bvh_nodes", "32 bytes a node: box, first child or item, link; traced units"),
    storage("bvh_parents", "u32 a node: the node above it, and in bits 30-31 the axis of that node's link"),
    storage("bvh_items", "u32 triangle ids, in the order of the leaves"),
    storage("wide_nodes", "80 bytes a node: eight quantised boxes; traced units"),
    storage("packed_triangles", "48 bytes an entry: corners and triangle id; traced units"),
    storage("normals", "nine f32 a triangle: unit vertex normals"),
    storage("texcoords", "six f32 a triangle: base colour texture coordinates"),
    storage("vertex_colors", "nine f32 a triangle: linear colours"),
    storage("triangle_materials", "u32 a triangle: index into materials"),
    storage("materials", "32 bytes: base colour, texture, emissive, double-sided"),
    storage("lights", "48 bytes: position, kind, direction, cone, colour"),
    storage("textures", "16 bytes: first texel, width, height, sampling"),
    storage("texels", "two u32 a texel: linear R G B, 16 bits each"),
];

/// The row with this name.
#[must_use]
pub fn info(name: &str) -> Option<&'static BufferInfo> {
    BUFFERS.iter().find(|b| b.name == name)
}
