//! Twin of `taking.wgsl`: which rays the fused kernel takes.

use super::waiting::Wait;
use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::programs::closest_hit::states::{ISECT_HIT, ISECT_NO_HIT, TRAV, TRAV_SETUP, UNWRITTEN};
use crate::programs::closest_hit::streams::{BOUNDS, STATE};
use crate::programs::closest_hit::tracing::Trace;
use crate::tables::state::Tag;
use crate::tables::texels::Texels;

/// Whether the ray is new, or waits.
pub(super) fn has_work<R: Real>(wait: &mut Wait, ray: &Texels<'_, R>, features: &Features) -> bool {
    let tag = ray.load_u32(STATE, 0);
    let is_new = tag == if features.eye_rays { UNWRITTEN } else { TRAV_SETUP };
    wait.before = features.resumes && (tag == TRAV || tag == ISECT_NO_HIT || tag == ISECT_HIT);
    is_new || wait.before
}

/// The state of a ray that waits.
pub(super) fn waits_as<R: Real>(trace: &Trace<R>, features: &Features) -> Tag {
    if features.bvh { TRAV } else { trace.listed_as(features) }
}

/// What the ray had found out about errors before it waited.
pub(super) fn load_bounds<R: Real>(trace: &mut Trace<R>, ray: &Texels<'_, R>, features: &Features) {
    if features.exact_order {
        (trace.error, trace.open) = (ray.load(BOUNDS, 0), ray.load(BOUNDS, 1));
    }
}

pub(super) fn keep_bounds<R: Real>(trace: &Trace<R>, ray: &mut Texels<'_, R>, features: &Features) {
    if features.exact_order {
        ray.store(BOUNDS, 0, trace.error);
        ray.store(BOUNDS, 1, trace.open);
    }
}
