//! Twin of `sample_bsdf.wgsl`: sends a path on in a direction that the surface's BSDF decides, or ends it.

use super::direction::cosine_weighted;
use super::next_sample;
use super::random::{FOR_CHANCE, FOR_DIRECTION, decided_by};
use super::sample_light::INVERSE_PI;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::load_direction;
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::programs::closest_hit::states::{DONE, OCCLUDED, SCATTER, TRAV_SETUP, VISIBLE};
use crate::programs::closest_hit::streams::{
    BOUNCE, COLOR, COUNTERS, ENDED, HIT, PDF, PENDING, RADIANCE, RAY_DIRECTION, RAY_ORIGIN, SHADOW_COUNTERS, SPENT,
    STATE, SURFACE, THROUGHPUT,
};
use crate::programs::light::optics::{optics_of, split};
use crate::programs::light::scatter::put_back_primary;
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::shading::{DIFFUSE, MIRROR};
use crate::shared::start::{leaving, start_of, through};
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

/// The cost of the path so far: the counters begin again with each ray.
fn spend<R: Real>(ray: &mut Texels<'_, R>, has_shadow: bool, is_first: bool, is_last: bool) {
    for layer in 0..3 {
        let before = if is_first { 0 } else { ray.load_u32(SPENT, layer) };
        let of_shadow = if has_shadow { ray.load_u32(SHADOW_COUNTERS, layer) } else { 0 };
        let sum = before + ray.load_u32(COUNTERS, layer) + of_shadow;
        ray.store_u32(SPENT, layer, sum);
        if is_last {
            ray.store_u32(COUNTERS, layer, sum);
        }
    }
}

fn scattered<R: Real>(ray: &Texels<'_, R>, scene: &SceneData, depth: u32, triangle: u32, carried: Vec3<R>) -> Next<R> {
    let (sampler, seed, sample) = (scene.features.sampler(), scene.sampling.seed, next_sample(ray, scene));
    let pair = |what| decided_by(sampler, seed, [ray.x, ray.y], sample, depth, what).map(R::from_f32);
    let [u, v]: [R; 2] = [ray.load(HIT, 0), ray.load(HIT, 1)];
    let direction = unit3(load_direction(ray));
    let start = start_of(scene.corners(triangle), [u, v], direction);
    let interpolated = surface_normal(scene, triangle, u, v);
    let is_turned = dot3(interpolated, start.normal) < R::zero();
    let normal = if is_turned { -interpolated } else { interpolated };
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
        let mut at = split(optic, direction, normal, start.is_back);
        if dot3(at.reflected, start.normal) <= R::zero() || dot3(at.refracted, start.normal) >= R::zero() {
            at = split(optic, direction, start.normal, start.is_back);
        }
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

fn go_on<R: Real>(ray: &mut Texels<'_, R>, next: &Next<R>, depth: u32, triangle: u32) {
    ray.store_vec3(RAY_ORIGIN, next.origin);
    ray.store_vec3(RAY_DIRECTION, next.direction);
    ray.store_vec3(THROUGHPUT, next.throughput);
    ray.store(PDF, 0, next.pdf);
    ray.store_u32(SURFACE, 0, triangle);
    ray.store_u32(BOUNCE, 0, depth);
    ray.store(HIT, 0, R::zero());
    ray.store(HIT, 1, R::zero());
    ray.store_u32(HIT, 2, NO_TRIANGLE);
    ray.store(STATE, 1, R::from_f32(INF));
    ray.store_u32(STATE, 2, 0);
    ray.store_u32(STATE, 3, 0);
    ray.store_u32(STATE, 0, TRAV_SETUP);
}

/// Processes one ray.
pub fn sample_bsdf<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if tag != SCATTER && tag != OCCLUDED && tag != VISIBLE {
        return;
    }
    let features = &scene.features;
    let depth = ray.load_u32(BOUNCE, 0);
    let carried = if depth > 0 { ray.load_vec3(THROUGHPUT) } else { Vec3::splat(R::one()) };
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
        spend(ray, features.shadows && tag != SCATTER, depth == 0, ended != 0);
    }
    if let (Some(next), 0) = (&next, ended) {
        go_on(ray, next, depth + 1, triangle);
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
