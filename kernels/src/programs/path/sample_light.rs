//! Twin of `sample_light.wgsl`: adds what a surface emits to a path's light, and casts a shadow ray to an emitter.

use super::emitters::{cone_of, pdf_by_area, picked, weight};
use super::next_sample;
use super::random::{FOR_EMITTER, FOR_POINT, decided_by};
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::programs::closest_hit::states::{BACKGROUND, SCATTER, SHADE, SHADOW_SETUP};
use crate::programs::closest_hit::streams::{
    BLOCKER, BOUNCE, HIT, LIGHT, PDF, PENDING, RADIANCE, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, SURFACE, THROUGHPUT,
};
use crate::programs::light::optics::optics_of;
use crate::programs::light::scatter::keep_primary;
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::emitters::PUNCTUAL;
use crate::shared::shading::{DIFFUSE, DIRECTIONAL, Material, SPOT};
use crate::shared::start::{Start, end_before, leaving, start_of};
use crate::shared::vector::{cross3, dot3, largest3, unit3};
use crate::tables::texels::Texels;

/// 1 / π.
pub(super) const INVERSE_PI: f32 = std::f32::consts::FRAC_1_PI;

/// The share of the light that a surface emits along a path that hits it by chance.
fn share_of_hit<R: Real>(
    ray: &Texels<'_, R>,
    scene: &SceneData,
    start: &Start<R>,
    material: &Material,
    direction: Vec3<R>,
) -> R {
    let of_direction: R = ray.load(PDF, 0);
    if of_direction == R::zero() {
        return R::one();
    }
    if scene.features.mis {
        let way = start.point - load_origin(ray);
        let area: R = pdf_by_area(scene, material);
        return weight(of_direction, area * dot3(way, way) / dot3(start.normal, direction).abs());
    }
    if scene.features.by_light { R::zero() } else { R::one() }
}

/// Casts a shadow ray from a hit to an emitter, unless nothing of its light can arrive. `carried`: what of light that is
/// reflected reaches the pixel, times the surface's colour.
fn is_cast<R: Real>(
    ray: &mut Texels<'_, R>,
    scene: &SceneData,
    depth: u32,
    start: &Start<R>,
    normal: Vec3<R>,
    carried: Vec3<R>,
) -> bool {
    let features = &scene.features;
    let (sampler, seed, sample) = (features.sampler(), scene.sampling.seed, next_sample(ray, scene));
    let pair = |what| decided_by(sampler, seed, [ray.x, ray.y], sample, depth, what);
    let emitter = picked(scene, pair(FOR_EMITTER));
    let origin = leaving(start);
    let mut end = R::from_f32(INF);
    let mut of_point = R::zero();
    let (direction, mut arrives);
    if emitter.id & PUNCTUAL != 0 {
        let light = &scene.lights[(emitter.id ^ PUNCTUAL) as usize];
        let mut intensity = Vec3::<R>::from_f32(light.color) * (R::one() / R::from_f32(emitter.chance));
        let mut way = -Vec3::<R>::from_f32(light.direction);
        if light.kind != DIRECTIONAL {
            let position = Vec3::from_f32(light.position);
            way = position - origin;
            end = end_before(position, way);
            intensity = intensity * (R::one() / dot3(way, way));
        }
        if features.spot_lights && light.kind == SPOT {
            intensity = intensity * cone_of(light, unit3(way));
        }
        (direction, arrives) = (way, intensity);
    } else {
        if !features.emissive {
            return false;
        }
        let [a, b, c]: [Vec3<R>; 3] = scene.corners(emitter.id);
        let (ab, ac) = (b - a, c - a);
        let by = pair(FOR_POINT).map(R::from_f32);
        let side = by[0].sqrt();
        let point = a + (ab * (side * (R::one() - by[1])) + ac * (side * by[1]));
        direction = point - origin;
        end = end_before(point, direction);
        let material = material_of(scene, emitter.id);
        let facing = -dot3(unit3(cross3(unit3(ab), unit3(ac))), unit3(direction));
        let cosine = if material.double_sided != 0 { facing.abs() } else { facing };
        if cosine <= R::zero() {
            return false;
        }
        let area: R = pdf_by_area(scene, material);
        of_point = area * dot3(direction, direction) / cosine;
        arrives = Vec3::from_f32(material.emissive) * (R::one() / of_point);
    }
    let cosine = dot3(normal, unit3(direction));
    if cosine <= R::zero() || dot3(start.normal, direction) <= R::zero() {
        return false;
    }
    let of_direction = cosine * R::from_f32(INVERSE_PI);
    arrives = arrives * (carried * of_direction);
    if features.mis && of_point > R::zero() {
        arrives = arrives * weight(of_point, of_direction);
    }
    let most = largest3(arrives);
    if !(most > R::zero() && most < R::from_f32(INF)) {
        return false;
    }
    ray.store_vec3(SHADOW_ORIGIN, origin);
    ray.store_vec3(SHADOW_DIRECTION, direction);
    ray.store_vec3(PENDING, arrives);
    ray.store_u32(SURFACE, 0, ray.load_u32(HIT, 2));
    ray.store_u32(BLOCKER, 2, NO_TRIANGLE);
    ray.store_u32(LIGHT, 0, emitter.id);
    let t: R = ray.load(STATE, 1);
    ray.store(LIGHT, 1, t);
    ray.store(STATE, 1, end);
    ray.store_u32(STATE, 0, SHADOW_SETUP);
    true
}

/// Processes one ray.
pub fn sample_light<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if tag != SHADE && tag != BACKGROUND {
        return;
    }
    let features = &scene.features;
    let depth = ray.load_u32(BOUNCE, 0);
    let (mut carried, mut sum) = (Vec3::splat(R::one()), Vec3::splat(R::zero()));
    if depth == 0 {
        keep_primary(ray);
    } else {
        carried = ray.load_vec3(THROUGHPUT);
        sum = ray.load_vec3(RADIANCE);
    }
    if tag == BACKGROUND {
        ray.store_vec3(RADIANCE, sum + carried * Vec3::from_f32(scene.shading.background));
        ray.store_u32(STATE, 0, SCATTER);
        return;
    }
    let triangle = ray.load_u32(HIT, 2);
    let [u, v]: [R; 2] = [ray.load(HIT, 0), ray.load(HIT, 1)];
    let direction = unit3(load_direction(ray));
    let material = material_of(scene, triangle);
    let start = start_of(scene.corners(triangle), [u, v], direction);
    let glows = material.emissive != [0.0; 3] && (!start.is_back || material.double_sided != 0);
    if features.emissive && glows {
        let share = share_of_hit(ray, scene, &start, material, direction);
        sum = sum + carried * Vec3::from_f32(material.emissive) * share;
    }
    ray.store_vec3(RADIANCE, sum);
    let is_diffuse = !features.specular || optics_of(scene, triangle).kind == DIFFUSE;
    if features.shadows && depth < features.depth && is_diffuse {
        let interpolated = surface_normal(scene, triangle, u, v);
        let is_turned = dot3(interpolated, start.normal) < R::zero();
        let normal = if is_turned { -interpolated } else { interpolated };
        let carried = carried * diffuse_color(scene, material, triangle, [u, v]);
        if is_cast(ray, scene, depth, &start, normal, carried) {
            return;
        }
    }
    ray.store_u32(STATE, 0, SCATTER);
}
