// A path at one of its hits: what the kernels that decide about it there share.

import package::corners::{vertex};
import package::random::{next_sample};
import package::start::{Start, start_of, on_side};
import package::shade_surface::{Material, material_of, surface_normal, diffuse_color};

struct Vertex {
    texel: vec2u,
    // The index of the pixel's sample, and how many bounces led here.
    sample: u32,
    depth: u32,
    triangle: u32,
    // Along which the path came; length 1.
    direction: vec3f,
    start: Start,
    // Interpolated, on the side from which the path came.
    normal: vec3f,
    material: Material,
    // Its diffuse colour here.
    color: vec3f,
    // The share of the light along the path that reaches the pixel.
    carried: vec3f,
}

fn vertex_at(texel: vec2u, depth: u32, triangle: u32, u: f32, v: f32, direction: vec3f, carried: vec3f) -> Vertex {
    var at: Vertex;
    at.texel = texel;
    at.sample = next_sample(texel);
    at.depth = depth;
    at.triangle = triangle;
    at.direction = direction;
    at.start = start_of(vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u), u, v, direction);
    at.normal = on_side(at.start, surface_normal(triangle, u, v));
    at.material = material_of(triangle);
    at.color = diffuse_color(at.material, triangle, u, v);
    at.carried = carried;
    return at;
}
