//! Twin of `sample_bsdf.wgsl`: sends a path on in a direction that the surface's BSDF decides, or ends it.

use super::direction::cosine_weighted;
use super::next_sample;
use super::random::{FOR_CHANCE, FOR_DIRECTION, decided_by};
use super::sample_light::INVERSE_PI;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::load_direction;
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::programs::closest_hit::states::{DONE, OCCLUDED, SCATTER, VISIBLE};
use crate::programs::closest_hit::streams::{
    BOUNCE, COLOR, ENDED, HIT, PDF, PENDING, RADIANCE, SHADOW_COUNTERS, STATE, SURFACE,
};
use crate::programs::light::bounced::{begin_ray, carried_at, put_back_primary, spend};
use crate::programs::light::optics::{optics_of, split_at};
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::shading::{DIFFUSE, MIRROR};
use crate::shared::start::{leaving, on_side, start_of, through};
use crate::shared::vector::{dot3, largest3, unit3};
use crate::tables::texels::Texels;

/// Bounces before a path may end by chance.
pub(super) const ROULETTE_DEPTH: u32 = 3;
/// The largest chance to go on.
const MOST_CHANCE: f32 = 0.95;

/// Why a path ended: nothing was hit.
pub(super) const BY_ESCAPE: u32 = 1;
/// It has as many bounces as it may have.
pub(super) const BY_DEPTH: u32 = 2;
/// The surface reflects nothing.
pub(super) const BY_ABSORPTION: u32 = 3;
/// The direction leads below the triangle, whose interpolated normal is another one.
pub(super) const BY_SURFACE: u32 = 4;
/// By chance.
pub(super) const BY_ROULETTE: u32 = 5;

/// Where a path goes on.
struct Next<R> {
    origin: Vec3<R>,
    direction: Vec3<R>,
    /// What it carries.
    throughput: Vec3<R>,
    /// The pdf of the direction, by solid angle; 0 if there was no other.
    pdf: R,
    /// Why it ends instead, or 0.
    ended: u32,
}

fn scattered<R: Real>(ray: &Texels<'_, R>, scene: &SceneData, depth: u32, triangle: u32, carried: Vec3<R>) -> Next<R> {
    let (sampler, seed, sample) = (scene.features.sampler(), scene.sampling.seed, next_sample(ray, scene));
    let pair = |what| decided_by(sampler, seed, [ray.x, ray.y], sample, depth, what).map(R::from_f32);
    let [u, v]: [R; 2] = [ray.load(HIT, 0), ray.load(HIT, 1)];
    let direction = unit3(load_direction(ray));
    let start = start_of(scene.corners(triangle), [u, v], direction);
    let normal = on_side(&start, surface_normal(scene, triangle, u, v));
    let chance = pair(FOR_CHANCE);
    let mut next = Next {
        origin: leaving(&start),
        direction,
        throughput: carried * diffuse_color(scene, material_of(scene, triangle), triangle, [u, v]),
        pdf: R::zero(),
        ended: 0,
    };
    let optic = scene.features.specular.then(|| optics_of(scene, triangle)).filter(|optic| optic.kind != DIFFUSE);
    if let Some(optic) = optic {
        let at = split_at(optic, direction, normal, &start);
        next.direction = at.reflected;
        if optic.kind != MIRROR {
            if chance[0] < at.reflectance {
                next.throughput = carried;
            } else {
                (next.origin, next.direction) = (through(&start), at.refracted);
            }
        }
    } else {
        next.direction = cosine_weighted(normal, pair(FOR_DIRECTION));
        next.pdf = dot3(normal, next.direction) * R::from_f32(INVERSE_PI);
        if next.pdf <= R::zero() || dot3(start.normal, next.direction) <= R::zero() {
            next.ended = BY_SURFACE;
        }
    }
    let most = largest3(next.throughput);
    if most > R::zero() {
        if depth >= ROULETTE_DEPTH {
            let goes_on = most.min(R::from_f32(MOST_CHANCE));
            next.throughput = next.throughput * (R::one() / goes_on);
            if chance[1] >= goes_on && next.ended == 0 {
                next.ended = BY_ROULETTE;
            }
        }
    } else {
        next.ended = BY_ABSORPTION;
    }
    next
}

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
    let next = (is_hit && depth < features.depth).then(|| scattered(ray, scene, depth, triangle, carried));
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
