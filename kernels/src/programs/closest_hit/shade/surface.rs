//! Twin of `surface.wgsl`: normal and colour of a surface.

use crate::numbers::real::{Real, Vec3};
use crate::scene_data::SceneData;
use crate::shared::shading::{Material, NO_TEXTURE};
use crate::shared::texture::sample_texture;
use crate::shared::vector::{cross3, unit3};

/// The material of a triangle.
pub(in crate::programs) fn material_of(scene: &SceneData, triangle: u32) -> &Material {
    let index = if scene.features.many_materials { scene.triangle_materials[triangle as usize] } else { 0 };
    &scene.materials[index as usize]
}

/// Interpolates three floats given at each corner.
fn interpolated<R: Real>(values: &[f32], triangle: u32, [w, u, v]: [R; 3]) -> Vec3<R> {
    let first = 9 * triangle as usize;
    let corner = |c: usize| Vec3::<R>::from_f32([values[first + c], values[first + c + 1], values[first + c + 2]]);
    corner(0) * w + corner(3) * u + corner(6) * v
}

pub(in crate::programs) fn surface_normal<R: Real>(scene: &SceneData, triangle: u32, u: R, v: R) -> Vec3<R> {
    if scene.features.normals {
        return unit3(interpolated(&scene.normals, triangle, [R::one() - u - v, u, v]));
    }
    let [a, b, c] = scene.corners::<R>(triangle);
    // Each edge is normalised first: the product of two tiny ones would underflow.
    unit3(cross3(unit3(b - a), unit3(c - a)))
}

/// The colour of a surface, from the f32 of its streams.
pub(in crate::programs) fn albedo(scene: &SceneData, triangle: u32, weights: [f32; 2]) -> [f32; 3] {
    diffuse_color(scene, material_of(scene, triangle), triangle, weights).to_array()
}

/// The material's colour, times those of the vertices and of the texture.
pub(in crate::programs) fn diffuse_color<R: Real>(
    scene: &SceneData,
    material: &Material,
    triangle: u32,
    [u, v]: [R; 2],
) -> Vec3<R> {
    let features = &scene.features;
    let mut diffuse = Vec3::from_f32(material.base_color);
    let w = R::one() - u - v;
    if features.vertex_colors {
        diffuse = diffuse * interpolated(&scene.vertex_colors, triangle, [w, u, v]);
    }
    if features.textures && material.texture != NO_TEXTURE {
        let first = 6 * triangle as usize;
        let coordinate = |i: usize| R::from_f32(scene.texcoords[first + i]);
        let s = coordinate(0) * w + coordinate(2) * u + coordinate(4) * v;
        let r = coordinate(1) * w + coordinate(3) * u + coordinate(5) * v;
        diffuse = diffuse * sample_texture(&scene.textures, &scene.texels, material.texture, s, r);
    }
    diffuse
}
