//! Twin of `look_up.wgsl`: adds the light at a hit, and sends the ray on, begins the search for photons, or ends it.

use super::reflected::is_diffuse;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::load_direction;
use crate::programs::closest_hit::states::{DONE, GATHER, GATHERED, OCCLUDED, SCATTER, VISIBLE};
use crate::programs::closest_hit::streams::{
    BOUNCE, COLOR, ENDED, GATHERED_POWER, GATHERING, HIT, PDF, PENDING, RADIANCE, SHADOW_COUNTERS, STATE, SURFACE,
};
use crate::programs::light::bounced::{begin_ray, carried_at, put_back_primary, spend};
use crate::programs::path::connected::INVERSE_PI;
use crate::programs::path::scattered::{BY_DEPTH, BY_ESCAPE, scattered};
use crate::programs::path::vertex::Vertex;
use crate::scene_data::SceneData;
use crate::shared::constants::{NO_CELL, NO_TRIANGLE};
use crate::shared::vector::unit3;
use crate::tables::texels::Texels;

/// Why a pixel's latest ray ended, besides the reasons of a path.
pub(super) const BY_GATHERING: u32 = 6;

fn vertex_of_hit<'a, R: Real>(
    ray: &Texels<'_, R>,
    scene: &'a SceneData,
    depth: u32,
    triangle: u32,
    carried: Vec3<R>,
) -> Vertex<'a, R> {
    let [u, v]: [R; 2] = [ray.load(HIT, 0), ray.load(HIT, 1)];
    Vertex::new(ray, scene, depth, (triangle, [u, v]), unit3(load_direction(ray)), carried)
}

fn begin_search<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let radius = R::from_f32(scene.photon_map.radius);
    ray.store_u32(GATHERING, 0, NO_CELL);
    (1..GATHERING.layers()).for_each(|layer| ray.store_u32(GATHERING, layer, 0));
    ray.store(GATHERED_POWER, 0, -R::one());
    ray.store(GATHERED_POWER, 1, radius * radius);
    (2..GATHERED_POWER.layers()).for_each(|layer| ray.store(GATHERED_POWER, layer, R::zero()));
}

/// The flux by area that photons bring, by Jensen's cone filter.
fn irradiance<R: Real>(ray: &Texels<'_, R>, scene: &SceneData) -> Vec3<R> {
    let (map, f) = (&scene.photon_map, R::from_f32);
    let vec3 = |first: usize| Vec3::from([0, 1, 2].map(|part| ray.load(GATHERED_POWER, first + part)));
    let (power, weighted): (Vec3<R>, Vec3<R>) = (vec3(5), vec3(8));
    let whole = f(map.radius) * f(map.radius);
    let has_enough = ray.load_u32(GATHERING, 3) >= map.nearest;
    let squared = if has_enough { ray.load(GATHERED_POWER, 4) } else { whole };
    let squared = squared.max(whole * f(1e-6));
    let left = power - weighted * (R::one() / squared.sqrt());
    left.map(|part| part.max(R::zero())) * (f(3.0 * INVERSE_PI) / squared)
}

/// Processes one ray.
pub fn look_up<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if ![SCATTER, OCCLUDED, VISIBLE, GATHERED].contains(&tag) {
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
    if features.mapped && tag == GATHERED {
        let at = vertex_of_hit(ray, scene, depth, triangle, carried);
        sum = sum + at.carried * at.color * (irradiance(ray, scene) * R::from_f32(INVERSE_PI));
        return end(ray, BY_GATHERING, sum);
    }
    let is_specular = triangle != NO_TRIANGLE && !is_diffuse(scene, triangle);
    let next = (is_specular && depth < features.depth)
        .then(|| scattered(&vertex_of_hit(ray, scene, depth, triangle, carried), scene));
    let ended = match &next {
        Some(next) => next.ended,
        None if triangle == NO_TRIANGLE => BY_ESCAPE,
        None if is_specular => BY_DEPTH,
        None => BY_GATHERING,
    };
    if features.counters {
        let has_shadow = features.shadows && tag != SCATTER;
        let of_shadow = [0, 1, 2].map(|layer| if has_shadow { ray.load_u32(SHADOW_COUNTERS, layer) } else { 0 });
        spend(ray, of_shadow, depth == 0, ended != 0);
    }
    if features.mapped && ended == BY_GATHERING {
        begin_search(ray, scene);
        ray.store_u32(STATE, 0, GATHER);
        return;
    }
    let Some(next) = next.filter(|_| ended == 0) else { return end(ray, ended, sum) };
    begin_ray(ray, [next.origin, next.direction, next.throughput], triangle, depth + 1);
    ray.store(PDF, 0, next.pdf);
}

fn end<R: Real>(ray: &mut Texels<'_, R>, why: u32, sum: Vec3<R>) {
    put_back_primary(ray);
    ray.store_vec3(COLOR, sum);
    ray.store_u32(ENDED, 0, why);
    ray.store_u32(BOUNCE, 0, 0);
    ray.store(PDF, 0, R::zero());
    ray.store_u32(SURFACE, 0, NO_TRIANGLE);
    ray.store_u32(STATE, 0, DONE);
}
