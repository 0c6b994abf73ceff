//! Twin of `at_hit.wgsl`: a pixel's ray at its hit, after the shadow ray that was cast there.

use super::scattered::Next;
use super::vertex::Vertex;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::load_direction;
use crate::programs::closest_hit::states::{DONE, SCATTER, VISIBLE};
use crate::programs::closest_hit::streams::{
    BOUNCE, COLOR, ENDED, HIT, PDF, PENDING, RADIANCE, SHADOW_COUNTERS, STATE, SURFACE,
};
use crate::programs::light::bounced::{begin_ray, put_back_primary};
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::vector::unit3;
use crate::tables::texels::Texels;

pub(in crate::programs) fn vertex_of_hit<'a, R: Real>(
    ray: &Texels<'_, R>,
    scene: &'a SceneData,
    depth: u32,
    triangle: u32,
    carried: Vec3<R>,
) -> Vertex<'a, R> {
    let [u, v]: [R; 2] = [ray.load(HIT, 0), ray.load(HIT, 1)];
    Vertex::new(ray, scene, depth, (triangle, [u, v]), unit3(load_direction(ray)), carried)
}

/// The pixel's light so far, with what the shadow ray brought if nothing was in its way.
pub(in crate::programs) fn light_so_far<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, tag: u32) -> Vec3<R> {
    let mut sum: Vec3<R> = ray.load_vec3(RADIANCE);
    if scene.features.shadows && tag == VISIBLE {
        sum = sum + ray.load_vec3(PENDING);
        ray.store_vec3(RADIANCE, sum);
    }
    sum
}

/// The cost of the shadow ray, if one was cast.
pub(in crate::programs) fn cost_of_shadow<R: Real>(ray: &Texels<'_, R>, scene: &SceneData, tag: u32) -> [u32; 3] {
    let has_shadow = scene.features.shadows && tag != SCATTER;
    [0, 1, 2].map(|layer| if has_shadow { ray.load_u32(SHADOW_COUNTERS, layer) } else { 0 })
}

pub(in crate::programs) fn go_on<R: Real>(ray: &mut Texels<'_, R>, next: &Next<R>, triangle: u32, depth: u32) {
    begin_ray(ray, [next.origin, next.direction, next.throughput], triangle, depth + 1);
    ray.store(PDF, 0, next.pdf);
}

/// The pixel has its first ray and its hit again, and its next sample begins anywhere.
pub(in crate::programs) fn end<R: Real>(ray: &mut Texels<'_, R>, why: u32, sum: Vec3<R>) {
    put_back_primary(ray);
    ray.store_vec3(COLOR, sum);
    ray.store_u32(ENDED, 0, why);
    ray.store_u32(BOUNCE, 0, 0);
    ray.store(PDF, 0, R::zero());
    ray.store_u32(SURFACE, 0, NO_TRIANGLE);
    ray.store_u32(STATE, 0, DONE);
}
