//! Twin of `sample_light.wgsl`: adds what a surface emits to a path's light, and casts a shadow ray to an emitter.

use super::emitters::{pdf_by_area, share_of_hit, weight};
use super::toward::toward_emitter;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::programs::closest_hit::states::{BACKGROUND, SCATTER, SHADE, SHADOW_SETUP};
use crate::programs::closest_hit::streams::{
    BLOCKER, BOUNCE, HIT, LIGHT, PDF, PENDING, RADIANCE, SHADOW_DIRECTION, SHADOW_ORIGIN, STATE, SURFACE, THROUGHPUT,
};
use crate::programs::light::bounced::keep_primary;
use crate::programs::light::optics::optics_of;
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::shading::DIFFUSE;
use crate::shared::start::{Start, leaving, on_side, start_of};
use crate::shared::vector::{dot3, largest3, unit3};
use crate::tables::texels::Texels;

/// 1 / π.
pub(super) const INVERSE_PI: f32 = std::f32::consts::FRAC_1_PI;

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
    let origin = leaving(start);
    let to = toward_emitter(ray, scene, depth, origin);
    let cosine = dot3(normal, unit3(to.direction));
    if !to.is_lit || cosine <= R::zero() || dot3(start.normal, to.direction) <= R::zero() {
        return false;
    }
    let of_direction = cosine * R::from_f32(INVERSE_PI);
    let mut arrives = to.light * (carried * of_direction);
    if scene.features.mis && to.pdf > R::zero() {
        arrives = arrives * weight(to.pdf, of_direction);
    }
    let most = largest3(arrives);
    if !(most > R::zero() && most < R::from_f32(INF)) {
        return false;
    }
    ray.store_vec3(SHADOW_ORIGIN, origin);
    ray.store_vec3(SHADOW_DIRECTION, to.direction);
    ray.store_vec3(PENDING, arrives);
    ray.store_u32(SURFACE, 0, ray.load_u32(HIT, 2));
    ray.store_u32(BLOCKER, 2, NO_TRIANGLE);
    ray.store_u32(LIGHT, 0, to.id);
    let t: R = ray.load(STATE, 1);
    ray.store(LIGHT, 1, t);
    ray.store(STATE, 1, to.end);
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
        let way = start.point - load_origin(ray);
        let area: R = pdf_by_area(scene, material);
        let of_point = area * dot3(way, way) / dot3(start.normal, direction).abs();
        let share = share_of_hit(features, ray.load(PDF, 0), of_point);
        sum = sum + carried * Vec3::from_f32(material.emissive) * share;
    }
    ray.store_vec3(RADIANCE, sum);
    let is_diffuse = !features.specular || optics_of(scene, triangle).kind == DIFFUSE;
    if features.shadows && depth < features.depth && is_diffuse {
        let normal = on_side(&start, surface_normal(scene, triangle, u, v));
        let carried = carried * diffuse_color(scene, material, triangle, [u, v]);
        if is_cast(ray, scene, depth, &start, normal, carried) {
            return;
        }
    }
    ray.store_u32(STATE, 0, SCATTER);
}
