// Triangles in the fused kernel's format: three vectors each with the corners, and the triangle's id in w of the first.
// Traced units.

@group(1) @binding(15) var<storage, read> packed_triangles: array<vec4u>;

struct PackedTriangle {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    id: u32,
}

fn packed_triangle(entry: u32) -> PackedTriangle {
    let a = packed_triangles[3u * entry];
    let b = packed_triangles[3u * entry + 1u];
    let c = packed_triangles[3u * entry + 2u];
    return PackedTriangle(bitcast<vec3f>(a.xyz), bitcast<vec3f>(b.xyz), bitcast<vec3f>(c.xyz), a.w);
}
