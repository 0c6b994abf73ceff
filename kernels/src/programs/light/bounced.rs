//! Twin of `bounced.wgsl`: a pixel's rays, one after the other. Each takes the place of the one before, and at the end the
//! first is put back.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::states::TRAV_SETUP;
use crate::programs::closest_hit::streams::{
    BOUNCE, COUNTERS, HIT, PRIMARY, RAY_DIRECTION, RAY_ORIGIN, SPENT, STATE, SURFACE, THROUGHPUT,
};
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::stream::Stream;
use crate::tables::texels::Texels;

/// Where the pixel's first ray and its hit are, in the order in which [`PRIMARY`] keeps them. Of the last, the triangle,
/// the layer holds an id.
const OF_PRIMARY: [(Stream, usize); 10] = [
    (RAY_ORIGIN, 0),
    (RAY_ORIGIN, 1),
    (RAY_ORIGIN, 2),
    (RAY_DIRECTION, 0),
    (RAY_DIRECTION, 1),
    (RAY_DIRECTION, 2),
    (STATE, 1),
    (HIT, 0),
    (HIT, 1),
    (HIT, 2),
];

/// Keeps the pixel's first ray and its hit.
pub(in crate::programs) fn keep_primary<R: Real>(ray: &mut Texels<'_, R>) {
    for (kept, (stream, layer)) in OF_PRIMARY.into_iter().enumerate() {
        copy(ray, (stream, layer), (PRIMARY, kept));
    }
}

/// Puts them back.
pub(in crate::programs) fn put_back_primary<R: Real>(ray: &mut Texels<'_, R>) {
    for (kept, (stream, layer)) in OF_PRIMARY.into_iter().enumerate() {
        copy(ray, (PRIMARY, kept), (stream, layer));
    }
}

/// Copies a component: all are floats but a triangle's id, which is that of [`HIT`] and the last of [`PRIMARY`].
fn copy<R: Real>(ray: &mut Texels<'_, R>, from: (Stream, usize), to: (Stream, usize)) {
    if [from, to].contains(&(HIT, 2)) {
        ray.store_u32(to.0, to.1, ray.load_u32(from.0, from.1));
    } else {
        let value: R = ray.load(from.0, from.1);
        ray.store(to.0, to.1, value);
    }
}

/// The share of the light along a ray that reaches the pixel.
pub(in crate::programs) fn carried_at<R: Real>(ray: &Texels<'_, R>, depth: u32) -> Vec3<R> {
    if depth == 0 { Vec3::splat(R::one()) } else { ray.load_vec3(THROUGHPUT) }
}

/// A ray leaves a triangle: its origin, direction and throughput.
pub(in crate::programs) fn begin_ray<R: Real>(
    ray: &mut Texels<'_, R>,
    [origin, direction, carried]: [Vec3<R>; 3],
    triangle: u32,
    depth: u32,
) {
    ray.store_vec3(RAY_ORIGIN, origin);
    ray.store_vec3(RAY_DIRECTION, direction);
    ray.store_vec3(THROUGHPUT, carried);
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

/// The cost of the pixel's rays so far, with that of a shadow ray: the counters begin again with each.
pub(in crate::programs) fn spend<R: Real>(ray: &mut Texels<'_, R>, of_shadow: [u32; 3], is_first: bool, is_last: bool) {
    for (layer, of_shadow) in of_shadow.into_iter().enumerate() {
        let before = if is_first { 0 } else { ray.load_u32(SPENT, layer) };
        let sum = before + ray.load_u32(COUNTERS, layer) + of_shadow;
        ray.store_u32(SPENT, layer, sum);
        if is_last {
            ray.store_u32(COUNTERS, layer, sum);
        }
    }
}
