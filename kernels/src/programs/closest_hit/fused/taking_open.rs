//! Twin of `taking_open.wgsl`: which rays the kernel `decide` takes.

use super::waiting::Wait;
use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::programs::closest_hit::states::EXACT;
use crate::programs::closest_hit::streams::{BOUNDS, STATE};
use crate::programs::closest_hit::tracing::Trace;
use crate::shared::constants::INF;
use crate::tables::texels::Texels;

/// In the place of the smallest open t of a ray that waits for integers to go on.
const WAITS: f32 = -1.0;

/// Whether integers have to decide what the ray hits.
pub(super) fn has_work<R: Real>(wait: &mut Wait, ray: &mut Texels<'_, R>, features: &Features) -> bool {
    let is_open = ray.load_u32(STATE, 0) == EXACT;
    if is_open && features.resumes && ray.load(BOUNDS, 1) == R::from_f32(WAITS) {
        wait.before = true;
        ray.store(BOUNDS, 1, R::from_f32(INF));
    }
    is_open
}

/// What the ray had found out about errors before it waited.
pub(super) fn load_bounds<R: Real>(trace: &mut Trace<R>, ray: &Texels<'_, R>) {
    trace.error = ray.load(BOUNDS, 0);
}

pub(super) fn keep_bounds<R: Real>(trace: &Trace<R>, ray: &mut Texels<'_, R>) {
    ray.store(BOUNDS, 0, trace.error);
    ray.store(BOUNDS, 1, R::from_f32(WAITS));
}
