// Normal and colour of a surface, from its triangle and the weights of a hit.

import package::corners::{vertex};
import package::vector::{cross3, unit3};
import package::texture::{sample_texture};

struct Material {
    base_color: vec3f,
    // Index into textures, 0xffffffff for none.
    texture: u32,
    emissive: vec3f,
    double_sided: u32,
}

@if(normals) @group(1) @binding(6) var<storage, read> normals: array<f32>;
@if(textures) @group(1) @binding(7) var<storage, read> texcoords: array<f32>;
@if(vertex_colors) @group(1) @binding(8) var<storage, read> vertex_colors: array<f32>;
@if(many_materials) @group(1) @binding(9) var<storage, read> triangle_materials: array<u32>;
@group(1) @binding(10) var<storage, read> materials: array<Material>;

// The material of a triangle.
fn material_of(triangle: u32) -> Material {
    @if(many_materials) return materials[triangle_materials[triangle]];
    @else return materials[0];
}

@if(!normals)
fn surface_normal(triangle: u32, u: f32, v: f32) -> vec3f {
    let a = vertex(triangle, 0u);
    // Each edge is normalised first: the product of two tiny ones would underflow.
    return unit3(cross3(unit3(vertex(triangle, 1u) - a), unit3(vertex(triangle, 2u) - a)));
}

@if(normals)
fn corner_normal(triangle: u32, corner: u32) -> vec3f {
    let first = 9u * triangle + 3u * corner;
    return vec3f(normals[first], normals[first + 1u], normals[first + 2u]);
}

@if(normals)
fn surface_normal(triangle: u32, u: f32, v: f32) -> vec3f {
    let w = 1.0 - u - v;
    return unit3(corner_normal(triangle, 0u) * w + corner_normal(triangle, 1u) * u + corner_normal(triangle, 2u) * v);
}

@if(vertex_colors)
fn corner_color(triangle: u32, corner: u32) -> vec3f {
    let first = 9u * triangle + 3u * corner;
    return vec3f(vertex_colors[first], vertex_colors[first + 1u], vertex_colors[first + 2u]);
}

// C_diff: the material's colour, times those of the vertices and of the texture.
fn diffuse_color(material: Material, triangle: u32, u: f32, v: f32) -> vec3f {
    var diffuse = material.base_color;
    let w = 1.0 - u - v;
    @if(vertex_colors) {
        diffuse = diffuse
            * (corner_color(triangle, 0u) * w + corner_color(triangle, 1u) * u + corner_color(triangle, 2u) * v);
    }
    @if(textures) {
        if (material.texture != 0xffffffffu) {
            let first = 6u * triangle;
            let s = texcoords[first] * w + texcoords[first + 2u] * u + texcoords[first + 4u] * v;
            let r = texcoords[first + 1u] * w + texcoords[first + 3u] * u + texcoords[first + 5u] * v;
            diffuse = diffuse * sample_texture(material.texture, s, r);
        }
    }
    return diffuse;
}
