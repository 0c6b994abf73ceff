//! Twin of `acceptance.wgsl`: whether, by an exact order, a hit replaces the nearest one so far.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::streams::{BOUNDS, HIT};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::triangle::Candidate;
use crate::tables::texels::Texels;

/// Whether the hit on a triangle does.
pub(super) fn is_kept<R: Real>(
    ray: &mut Texels<'_, R>,
    scene: &SceneData,
    (origin, direction): (Vec3<R>, Vec3<R>),
    candidate: &Candidate<R>,
    triangle: u32,
    nearest_t: R,
) -> bool {
    if !candidate.is_hit {
        return false;
    }
    let mut trace = Trace::new(origin, direction, [R::zero(); 2], NO_TRIANGLE, nearest_t);
    (trace.error, trace.open) = (ray.load(BOUNDS, 0), ray.load(BOUNDS, 1));
    trace.triangle = ray.load_u32(HIT, 2);
    let before = trace.triangle;
    trace.order(scene, candidate, triangle, scene.corners(triangle));
    ray.store(BOUNDS, 0, trace.error);
    ray.store(BOUNDS, 1, trace.open);
    trace.triangle != before
}
