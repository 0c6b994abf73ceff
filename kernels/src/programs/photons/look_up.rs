//! Twin of `look_up.wgsl`: adds the light at a hit, and sends the ray on, begins the search for photons, or ends it.

use super::reflected::is_diffuse;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::load_direction;
use crate::programs::closest_hit::states::{DONE, GATHER, GATHERED, OCCLUDED, SCATTER, VISIBLE};
use crate::programs::closest_hit::streams::{
    BOUNCE, COLOR, ENDED, GATHERED_POWER, GATHERING, HIT, PDF, PENDING, RADIANCE, SHADOW_COUNTERS, SHRUNK, STATE,
    SURFACE,
};
use crate::programs::light::bounced::{begin_ray, carried_at, put_back_primary, spend};
use crate::programs::path::connected::INVERSE_PI;
use crate::programs::path::scattered::{BY_DEPTH, BY_ESCAPE, Next, scattered};
use crate::programs::path::vertex::Vertex;
use crate::scene_data::SceneData;
use crate::shared::constants::{NO_CELL, NO_TRIANGLE};
use crate::shared::photon_map::{CAUSTIC, GLOBAL};
use crate::shared::vector::unit3;
use crate::tables::texels::Texels;

/// Why a pixel's latest ray ended, besides the reasons of a path.
pub(super) const BY_GATHERING: u32 = 6;
/// Of the photons found in an iteration, the share that counts in the next.
const KEPT: f32 = 0.666_666_7;

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

/// Layers of [`SHRUNK`] that begin with those of a search.
fn slot(map: u32, is_sent: u32) -> usize {
    (4 * is_sent + 2 * map) as usize
}

/// The squared radius that earlier iterations have left, or 0.
fn radius_before<R: Real>(ray: &Texels<'_, R>, scene: &SceneData, map: u32, is_sent: u32) -> R {
    if scene.features.samples { ray.load(SHRUNK, slot(map, is_sent) + 1) } else { R::zero() }
}

/// Begins the search for photons of a map.
fn search<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, map: u32, is_sent: u32) {
    let radius = R::from_f32(scene.photon_map.radius);
    let before = radius_before(ray, scene, map, is_sent);
    let has_radius = before > R::zero();
    let limit = if has_radius { before } else { radius * radius };
    for (layer, word) in [NO_CELL, 0, 0, 0, u32::from(has_radius), map, is_sent, 0].into_iter().enumerate() {
        ray.store_u32(GATHERING, layer, word);
    }
    (0..GATHERED_POWER.layers()).for_each(|layer| ray.store(GATHERED_POWER, layer, R::zero()));
    ray.store(GATHERED_POWER, 0, limit);
    ray.store(GATHERED_POWER, 2, limit);
    ray.store_u32(STATE, 0, GATHER);
}

/// The flux by area that photons bring, by Jensen's cone filter; with several iterations, the radius shrinks.
fn irradiance<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, map: u32, is_sent: u32) -> Vec3<R> {
    let (grid, f) = (&scene.photon_map, R::from_f32);
    let vec3 = |first: usize| Vec3::from([0, 1, 2].map(|part| ray.load(GATHERED_POWER, first + part)));
    let (power, weighted): (Vec3<R>, Vec3<R>) = (vec3(4), vec3(7));
    let whole = f(grid.radius) * f(grid.radius);
    let before = radius_before(ray, scene, map, is_sent);
    let found = ray.load_u32(GATHERING, 3);
    let of_search = if found >= grid.nearest { ray.load(GATHERED_POWER, 3) } else { whole };
    let squared = if before > R::zero() { before } else { of_search }.max(whole * f(1e-6));
    if scene.features.samples {
        let (slot, found) = (slot(map, is_sent), f(found as f32));
        let enough: R = ray.load(SHRUNK, slot);
        let kept = enough + f(KEPT) * found;
        ray.store(SHRUNK, slot, kept);
        let shrunk = if found > R::zero() { squared * (kept / (enough + found)) } else { squared };
        ray.store(SHRUNK, slot + 1, shrunk);
    }
    let left = power - weighted * (R::one() / squared.sqrt());
    left.map(|part| part.max(R::zero())) * (f(3.0 * INVERSE_PI) / squared)
}

/// Sends a ray on from its first diffuse surface.
fn send_on<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, at: &Vertex<'_, R>, sum: Vec3<R>) {
    let next = scattered(at, scene);
    if next.ended != 0 {
        return end(ray, scene, next.ended, sum);
    }
    ray.store_u32(GATHERING, 6, 1);
    go_on(ray, scene, &next, at.triangle, at.depth);
}

fn go_on<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, next: &Next<R>, triangle: u32, depth: u32) {
    begin_ray(ray, [next.origin, next.direction, next.throughput], triangle, depth + 1);
    // A lamp that a mirror shows to a diffuse surface is in the map of caustics there: as if light had been picked for it.
    let is_sent = scene.features.mapped && scene.features.gathers_later && ray.load_u32(GATHERING, 6) != 0;
    ray.store(PDF, 0, if is_sent { R::one() } else { next.pdf });
}

/// After a search: adds what its photons bring, and looks in the other map, or sends the ray on, or ends it.
fn after_search<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, at: &Vertex<'_, R>, before: Vec3<R>) {
    let features = &scene.features;
    let [map, is_sent] = [5, 6].map(|layer| ray.load_u32(GATHERING, layer));
    let sum = before + at.carried * at.color * (irradiance(ray, scene, map, is_sent) * R::from_f32(INVERSE_PI));
    if !features.specular || map != CAUSTIC {
        return end(ray, scene, BY_GATHERING, sum);
    }
    ray.store_vec3(RADIANCE, sum);
    if features.gathers_later && is_sent == 0 && at.depth < features.depth {
        return send_on(ray, scene, at, sum);
    }
    search(ray, scene, GLOBAL, is_sent);
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
        return after_search(ray, scene, &at, sum);
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
        let is_sent = ray.load_u32(GATHERING, 6);
        if features.gathers_later && !features.specular && is_sent == 0 && depth < features.depth {
            return send_on(ray, scene, &vertex_of_hit(ray, scene, depth, triangle, carried), sum);
        }
        return search(ray, scene, if features.specular { CAUSTIC } else { GLOBAL }, is_sent);
    }
    let Some(next) = next.filter(|_| ended == 0) else { return end(ray, scene, ended, sum) };
    go_on(ray, scene, &next, triangle, depth);
}

fn end<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, why: u32, sum: Vec3<R>) {
    put_back_primary(ray);
    ray.store_vec3(COLOR, sum);
    ray.store_u32(ENDED, 0, why);
    ray.store_u32(BOUNCE, 0, 0);
    ray.store(PDF, 0, R::zero());
    ray.store_u32(SURFACE, 0, NO_TRIANGLE);
    if scene.features.mapped {
        ray.store_u32(GATHERING, 6, 0);
    }
    ray.store_u32(STATE, 0, DONE);
}
