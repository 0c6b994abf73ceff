//! Twin of `sample_bsdf.wgsl`: adds what the shadow ray brought, and sends the path on, or ends it.

use super::scattered::{BY_DEPTH, BY_ESCAPE, scattered};
use super::vertex::Vertex;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::load_direction;
use crate::programs::closest_hit::states::{DONE, OCCLUDED, SCATTER, VISIBLE};
use crate::programs::closest_hit::streams::{
    BOUNCE, COLOR, ENDED, HIT, PDF, PENDING, RADIANCE, SHADOW_COUNTERS, STATE, SURFACE,
};
use crate::programs::light::bounced::{begin_ray, carried_at, put_back_primary, spend};
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::vector::unit3;
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn sample_bsdf<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if tag != SCATTER && tag != OCCLUDED && tag != VISIBLE {
        return;
    }
    let features = &scene.features;
    let depth = ray.load_u32(BOUNCE, 0);
    let carried = carried_at(ray, depth);
    let mut sum: Vec3<R> = ray.load_vec3(RADIANCE);
    if features.shadows && tag == VISIBLE {
        sum = sum + ray.load_vec3(PENDING);
        ray.store_vec3(RADIANCE, sum);
    }
    let triangle = ray.load_u32(HIT, 2);
    let is_hit = triangle != NO_TRIANGLE;
    let mut ended = if is_hit { BY_DEPTH } else { BY_ESCAPE };
    let next = (is_hit && depth < features.depth).then(|| {
        let [u, v]: [R; 2] = [ray.load(HIT, 0), ray.load(HIT, 1)];
        let direction = unit3(load_direction(ray));
        scattered(&Vertex::new(ray, scene, depth, (triangle, [u, v]), direction, carried), scene)
    });
    if let Some(next) = &next {
        ended = next.ended;
    }
    if features.counters {
        let has_shadow = features.shadows && tag != SCATTER;
        let of_shadow = [0, 1, 2].map(|layer| if has_shadow { ray.load_u32(SHADOW_COUNTERS, layer) } else { 0 });
        spend(ray, of_shadow, depth == 0, ended != 0);
    }
    if let (Some(next), 0) = (&next, ended) {
        begin_ray(ray, [next.origin, next.direction, next.throughput], triangle, depth + 1);
        ray.store(PDF, 0, next.pdf);
        return;
    }
    put_back_primary(ray);
    ray.store_vec3(COLOR, sum);
    ray.store_u32(ENDED, 0, ended);
    ray.store_u32(BOUNCE, 0, 0);
    ray.store(PDF, 0, R::zero());
    ray.store_u32(SURFACE, 0, NO_TRIANGLE);
    ray.store_u32(STATE, 0, DONE);
}
