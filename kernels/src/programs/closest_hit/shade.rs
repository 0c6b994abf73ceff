//! Twin of `shade.wgsl`: colours the ray from its hit, or gives it the background's colour.

pub(in crate::programs) mod light;
pub(in crate::programs) mod surface;

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::states::{BACKGROUND, DONE, SHADE};
use crate::programs::closest_hit::streams::{COLOR, HIT, STATE};
use crate::scene_data::SceneData;
use crate::shared::constants::LIGHTS_SUMMED;
use crate::shared::vector::dot3;
use crate::tables::texels::Texels;
use light::received;
use surface::{diffuse_color, material_of, surface_normal};

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
        let material = material_of(scene, triangle);
        let direction = load_direction(ray);
        let position = load_origin(ray) + direction * t;
        let diffuse = diffuse_color(scene, material, triangle, [u, v]);
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
