// Positions of a triangle's corners: nine floats per triangle, traced units.

@group(1) @binding(3) var<storage, read> vertices: array<f32>;

fn vertex(triangle: u32, corner: u32) -> vec3f {
    let first = 9u * triangle + 3u * corner;
    return vec3f(vertices[first], vertices[first + 1u], vertices[first + 2u]);
}
