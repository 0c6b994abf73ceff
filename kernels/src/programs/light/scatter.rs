//! Twin of `scatter.wgsl`: adds the light of a ray's hit to the pixel's, and goes on with the rays that the surface reflects
//! and refracts.

use super::bounced::{begin_ray, carried_at, keep_primary, put_back_primary, spend};
use super::optics::{optics_of, split_at};
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::ray::load_direction;
use crate::programs::closest_hit::shade::surface::{diffuse_color, material_of, surface_normal};
use crate::programs::closest_hit::states::{DONE, SCATTER};
use crate::programs::closest_hit::streams::{BOUNCE, BRANCHES, COLOR, HIT, RADIANCE, STATE, SURFACE};
use crate::scene_data::SceneData;
use crate::shared::constants::{BRANCH, NO_TRIANGLE};
use crate::shared::shading::{DIFFUSE, MIRROR};
use crate::shared::start::{leaving, on_side, start_of, through};
use crate::shared::vector::unit3;
use crate::tables::texels::Texels;

/// A ray that goes on from a surface.
struct Next<R> {
    origin: Vec3<R>,
    direction: Vec3<R>,
    /// The share of its light that reaches the pixel.
    throughput: Vec3<R>,
    /// The triangle that it leaves.
    triangle: u32,
}

/// A ray that waits at a depth.
fn branch<R: Real>(ray: &Texels<'_, R>, depth: u32) -> Next<R> {
    let first = (depth * BRANCH) as usize;
    let at = |layer: usize| {
        let value = |axis: usize| ray.load(BRANCHES, first + layer + axis);
        Vec3::new(value(0), value(1), value(2))
    };
    Next { origin: at(0), direction: at(3), throughput: at(6), triangle: ray.load_u32(BRANCHES, first + 9) }
}

fn wait<R: Real>(ray: &mut Texels<'_, R>, depth: u32, next: &Next<R>) {
    let first = (depth * BRANCH) as usize;
    for (layer, v) in [(0, next.origin), (3, next.direction), (6, next.throughput)] {
        for (axis, value) in [v.x, v.y, v.z].into_iter().enumerate() {
            ray.store(BRANCHES, first + layer + axis, value);
        }
    }
    ray.store_u32(BRANCHES, first + 9, next.triangle);
}

fn go_on<R: Real>(ray: &mut Texels<'_, R>, next: &Next<R>, depth: u32, waiting: u32, sum: Vec3<R>) {
    begin_ray(ray, [next.origin, next.direction, next.throughput], next.triangle, depth);
    ray.store_u32(BOUNCE, 1, waiting);
    ray.store_vec3(RADIANCE, sum);
}

/// The rays that go on from a hit: what is reflected, and what is refracted.
fn sent<R: Real>(ray: &Texels<'_, R>, scene: &SceneData, triangle: u32, carried: Vec3<R>) -> [Option<Next<R>>; 2] {
    let of = optics_of(scene, triangle);
    if of.kind == DIFFUSE {
        return [None, None];
    }
    let [u, v]: [R; 2] = [ray.load(HIT, 0), ray.load(HIT, 1)];
    let direction = unit3(load_direction(ray));
    let start = start_of(scene.corners(triangle), [u, v], direction);
    let normal = on_side(&start, surface_normal(scene, triangle, u, v));
    let at = split_at(of, direction, normal, &start);
    let tint = carried * diffuse_color(scene, material_of(scene, triangle), triangle, [u, v]);
    let next = |origin, direction, throughput: Vec3<R>| {
        (throughput != Vec3::splat(R::zero())).then_some(Next { origin, direction, throughput, triangle })
    };
    // A mirror's colour is that of what it reflects; glass colours what passes through it.
    let reflected = if of.kind == MIRROR { tint } else { carried } * at.reflectance;
    let refracted = tint * (R::one() - at.reflectance);
    [next(leaving(&start), at.reflected, reflected), next(through(&start), at.refracted, refracted)]
}

/// Processes one ray.
pub fn scatter<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(STATE, 0) != SCATTER {
        return;
    }
    let features = &scene.features;
    let depth = ray.load_u32(BOUNCE, 0);
    let mut waiting = ray.load_u32(BOUNCE, 1);
    let carried = carried_at(ray, depth);
    let mut sum: Vec3<R> = ray.load_vec3(COLOR);
    if depth > 0 {
        sum = sum * carried + ray.load_vec3(RADIANCE);
    }

    let triangle = ray.load_u32(HIT, 2);
    let mut next = None;
    let mut next_depth = depth + 1;
    if triangle != NO_TRIANGLE && depth < features.depth {
        let [reflected, refracted] = sent(ray, scene, triangle, carried);
        if let (Some(refracted), true, true) = (&refracted, reflected.is_some(), features.dielectric) {
            wait(ray, depth, refracted);
            waiting |= 1 << depth;
        }
        next = reflected.or(refracted.filter(|_| features.dielectric));
        if depth == 0 && next.is_some() {
            keep_primary(ray);
        }
    }
    if next.is_none()
        && let Some(deepest) = waiting.checked_ilog2()
    {
        next = Some(branch(ray, deepest));
        next_depth = deepest + 1;
        waiting ^= 1 << deepest;
    }
    if features.counters {
        spend(ray, [0; 3], depth == 0, next.is_none());
    }
    if let Some(next) = next {
        go_on(ray, &next, next_depth, waiting, sum);
        return;
    }

    if depth > 0 {
        put_back_primary(ray);
        ray.store_vec3(COLOR, sum);
        ray.store_u32(BOUNCE, 0, 0);
    }
    ray.store_u32(SURFACE, 0, NO_TRIANGLE);
    ray.store_u32(STATE, 0, DONE);
}
