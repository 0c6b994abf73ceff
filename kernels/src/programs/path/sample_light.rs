//! Twin of `sample_light.wgsl`: adds what a surface emits to a path's light, and casts a shadow ray to an emitter.

use super::connected::{Connection, connected, emitted};
use super::vertex::Vertex;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::states::{BACKGROUND, SCATTER, SHADE, SHADOW_SETUP};
use crate::programs::closest_hit::streams::{
    BLOCKER, BOUNCE, HIT, LIGHT, PDF, PENDING, RADIANCE, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, SURFACE,
};
use crate::programs::light::bounced::{carried_at, keep_primary};
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::vector::unit3;
use crate::tables::texels::Texels;

fn cast_shadow<R: Real>(ray: &mut Texels<'_, R>, to: &Connection<R>) {
    ray.store_vec3(SHADOW_ORIGIN, to.origin);
    ray.store_vec3(SHADOW_DIRECTION, to.direction);
    ray.store_vec3(PENDING, to.arrives);
    ray.store_u32(SURFACE, 0, ray.load_u32(HIT, 2));
    ray.store_u32(BLOCKER, 2, NO_TRIANGLE);
    ray.store_u32(LIGHT, 0, to.id);
    let t: R = ray.load(STATE, 1);
    ray.store(LIGHT, 1, t);
    ray.store(STATE, 1, to.end);
    ray.store_u32(STATE, 0, SHADOW_SETUP);
}

/// Processes one ray.
pub fn sample_light<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if tag != SHADE && tag != BACKGROUND {
        return;
    }
    let depth = ray.load_u32(BOUNCE, 0);
    let carried = carried_at(ray, depth);
    let mut sum = Vec3::splat(R::zero());
    if depth == 0 {
        keep_primary(ray);
    } else {
        sum = ray.load_vec3(RADIANCE);
    }
    let mut next = SCATTER;
    if tag == BACKGROUND {
        sum = sum + carried * Vec3::from_f32(scene.shading.background);
    } else {
        let [u, v]: [R; 2] = [ray.load(HIT, 0), ray.load(HIT, 1)];
        let hit = (ray.load_u32(HIT, 2), [u, v]);
        let at = Vertex::new(ray, scene, depth, hit, unit3(load_direction(ray)), carried);
        if scene.features.emissive {
            sum = sum + emitted(&at, scene, load_origin(ray), ray.load(PDF, 0));
        }
        if let Some(to) = connected(&at, scene) {
            cast_shadow(ray, &to);
            next = SHADOW_SETUP;
        }
    }
    ray.store_vec3(RADIANCE, sum);
    ray.store_u32(STATE, 0, next);
}
