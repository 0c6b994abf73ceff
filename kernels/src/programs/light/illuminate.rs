//! Twin of `illuminate.wgsl`: casts a shadow ray to the next light, and adds what the ray before brought.

use super::optics::optics_of;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::shade::light::received;
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::programs::closest_hit::states::{BACKGROUND, DONE, OCCLUDED, SCATTER, SHADE, SHADOW_SETUP, VISIBLE};
use crate::programs::closest_hit::streams::{
    BLOCKER, COLOR, COUNTERS, HIT, LIGHT, PENDING, SHADOW_COUNTERS, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, SURFACE,
};
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, LIGHTS_SUMMED, NO_TRIANGLE};
use crate::shared::shading::{DIFFUSE, DIRECTIONAL, Light};
use crate::shared::start::{Start, end_before, leaving, start_of};
use crate::shared::vector::dot3;
use crate::tables::texels::Texels;

/// The light that has arrived so far. The pixel's cost includes that of its shadow rays.
fn arrived<R: Real>(ray: &mut Texels<'_, R>, tag: u32, has_counters: bool) -> Vec3<R> {
    let mut sum = ray.load_vec3(COLOR);
    if tag == VISIBLE {
        sum = sum + ray.load_vec3(PENDING);
    }
    if has_counters {
        for i in 0..3 {
            ray.store_u32(COUNTERS, i, ray.load_u32(COUNTERS, i) + ray.load_u32(SHADOW_COUNTERS, i));
        }
    }
    sum
}

/// Casts the shadow ray of light `i`, which brings `rgb`, unless the surface itself is in its way.
fn is_cast<R: Real>(ray: &mut Texels<'_, R>, light: &Light, start: &Start<R>, i: u32, rgb: Vec3<R>) -> bool {
    let origin = leaving(start);
    let mut direction = -Vec3::<R>::from_f32(light.direction);
    let mut end = R::from_f32(INF);
    if light.kind != DIRECTIONAL {
        let position = Vec3::<R>::from_f32(light.position);
        direction = position - origin;
        end = end_before(position, direction);
    }
    if dot3(start.normal, direction) <= R::zero() {
        return false;
    }
    ray.store_vec3(SHADOW_ORIGIN, origin);
    ray.store_vec3(SHADOW_DIRECTION, direction);
    ray.store_vec3(PENDING, rgb);
    ray.store_u32(SURFACE, 0, ray.load_u32(HIT, 2));
    ray.store_u32(BLOCKER, 2, NO_TRIANGLE);
    ray.store_u32(LIGHT, 0, i + 1);
    ray.store(STATE, 1, end);
    true
}

/// Processes one ray.
pub fn illuminate<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let features = &scene.features;
    let lit = if features.specular { SCATTER } else { DONE };
    let tag = ray.load_u32(STATE, 0);
    if tag == BACKGROUND {
        ray.store_vec3(COLOR, Vec3::from_f32(scene.shading.background));
        ray.store_u32(STATE, 0, lit);
        return;
    }
    if tag != SHADE && tag != OCCLUDED && tag != VISIBLE {
        return;
    }

    let mut first = 0;
    let mut sum = Vec3::splat(R::zero());
    let mut t: R = ray.load(STATE, 1);
    if tag == SHADE {
        ray.store(LIGHT, 1, t);
        if features.resumes_light {
            let item = ray.load_u32(STATE, 3);
            if item >= LIGHTS_SUMMED {
                first = item - LIGHTS_SUMMED;
                sum = ray.load_vec3(COLOR);
            }
        }
    } else {
        first = ray.load_u32(LIGHT, 0);
        sum = arrived(ray, tag, features.counters);
        t = ray.load(LIGHT, 1);
    }
    let u: R = ray.load(HIT, 0);
    let v: R = ray.load(HIT, 1);
    let triangle = ray.load_u32(HIT, 2);
    let material = material_of(scene, triangle);
    let direction = load_direction(ray);
    let position = load_origin(ray) + direction * t;
    let mut normal = surface_normal(scene, triangle, u, v);
    if features.double_sided && material.double_sided != 0 && dot3(normal, direction) > R::zero() {
        normal = -normal;
    }

    if features.specular && optics_of(scene, triangle).kind != DIFFUSE {
        first = scene.shading.lights;
    }
    let mut end = scene.shading.lights;
    if features.resumes_light {
        end = end.min(first + features.turns);
    }
    for i in first..end {
        let light = &scene.lights[i as usize];
        let rgb = received(light, position, normal);
        if rgb == Vec3::splat(R::zero()) {
            continue;
        }
        let start = start_of(scene.corners(triangle), [u, v], direction);
        if is_cast(ray, light, &start, i, rgb) {
            ray.store_vec3(COLOR, sum);
            ray.store_u32(STATE, 0, SHADOW_SETUP);
            return;
        }
    }
    if end < scene.shading.lights {
        ray.store_vec3(COLOR, sum);
        ray.store_u32(STATE, 0, SHADE);
        ray.store(STATE, 1, t);
        ray.store_u32(STATE, 3, LIGHTS_SUMMED + end);
        return;
    }
    let mut rgb = sum * diffuse_color(scene, material, triangle, [u, v]);
    if features.emissive {
        rgb = rgb + Vec3::from_f32(material.emissive);
    }
    ray.store_vec3(COLOR, rgb);
    ray.store(STATE, 1, t);
    ray.store_u32(STATE, 0, lit);
}
