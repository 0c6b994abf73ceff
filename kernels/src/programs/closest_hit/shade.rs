//! Twin of `shade.wgsl`: colours the ray from its hit, or gives it the background's colour.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::states::{BACKGROUND, DONE, SHADE};
use crate::programs::closest_hit::streams::{COLOR, HIT, STATE};
use crate::scene_data::SceneData;
use crate::shared::constants::LIGHTS_SUMMED;
use crate::shared::shading::{DIRECTIONAL, Light, NO_TEXTURE, SPOT};
use crate::shared::texture::sample_texture;
use crate::shared::vector::{cross3, dot3, unit3};
use crate::tables::texels::Texels;

/// Interpolates three floats given at each corner.
fn interpolated<R: Real>(values: &[f32], triangle: u32, [w, u, v]: [R; 3]) -> Vec3<R> {
    let first = 9 * triangle as usize;
    let corner = |c: usize| Vec3::<R>::from_f32([values[first + c], values[first + c + 1], values[first + c + 2]]);
    corner(0) * w + corner(3) * u + corner(6) * v
}

fn surface_normal<R: Real>(scene: &SceneData, triangle: u32, u: R, v: R) -> Vec3<R> {
    if scene.features.normals {
        return unit3(interpolated(&scene.normals, triangle, [R::one() - u - v, u, v]));
    }
    let [a, b, c] = scene.corners::<R>(triangle);
    // Each edge is normalised first: the product of two tiny ones would underflow.
    unit3(cross3(unit3(b - a), unit3(c - a)))
}

/// <N, L> of one light times its colour.
fn received<R: Real>(light: &Light, position: Vec3<R>, normal: Vec3<R>) -> Vec3<R> {
    let color = Vec3::<R>::from_f32(light.color);
    let direction = Vec3::<R>::from_f32(light.direction);
    let zero = R::zero();
    if light.kind == DIRECTIONAL {
        return color * dot3(normal, -direction).max(zero);
    }
    let to_light = unit3(Vec3::from_f32(light.position) - position);
    let amount = dot3(normal, to_light).max(zero);
    if light.kind == SPOT {
        let cone = (dot3(-to_light, direction) - R::from_f32(light.cos_outer)) * R::from_f32(light.cone_scale);
        let cone = cone.max(zero).min(R::one());
        return color * (amount * cone * cone);
    }
    color * amount
}

/// Processes one ray.
pub fn shade<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if tag != SHADE && tag != BACKGROUND {
        return;
    }
    let features = &scene.features;

    let mut rgb = Vec3::from_f32(scene.shading.background);
    if tag == SHADE {
        let t: R = ray.load(STATE, 1);
        let u: R = ray.load(HIT, 0);
        let v: R = ray.load(HIT, 1);
        let triangle = ray.load_u32(HIT, 2);
        let index = if features.many_materials { scene.triangle_materials[triangle as usize] } else { 0 };
        let material = &scene.materials[index as usize];
        let direction = load_direction(ray);
        let position = load_origin(ray) + direction * t;

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
        let mut normal = surface_normal(scene, triangle, u, v);
        if features.double_sided && material.double_sided != 0 && dot3(normal, direction) > R::zero() {
            normal = -normal;
        }

        if features.many_lights {
            rgb = Vec3::splat(R::zero());
            let (mut first, mut end) = (0, scene.shading.lights);
            if features.resumes_light {
                let item = ray.load_u32(STATE, 3);
                if item >= LIGHTS_SUMMED {
                    first = item - LIGHTS_SUMMED;
                    rgb = ray.load_vec3(COLOR);
                }
                end = end.min(first + features.turns);
            }
            for light in &scene.lights[first as usize..end as usize] {
                rgb = rgb + received(light, position, normal);
            }
            if end < scene.shading.lights {
                ray.store_vec3(COLOR, rgb);
                ray.store_u32(STATE, 3, LIGHTS_SUMMED + end);
                return;
            }
        } else {
            rgb = received(&scene.lights[0], position, normal);
        }
        rgb = rgb * diffuse;
        if features.emissive {
            rgb = rgb + Vec3::from_f32(material.emissive);
        }
    }
    ray.store_vec3(COLOR, rgb);
    ray.store_u32(STATE, 0, DONE);
}
