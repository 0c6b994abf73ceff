//! Twin of `bounds.wgsl`: what is certain of the nearest hit of a ray that takes its steps in several passes.

use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::programs::closest_hit::states::{BACKGROUND, EXACT, SHADE};
use crate::programs::closest_hit::streams::BOUNDS;
use crate::shared::constants::INF;
use crate::tables::state::Tag;
use crate::tables::texels::Texels;

/// The largest t that the hit may have whose t is stored.
pub(super) fn latest_of<R: Real>(ray: &Texels<'_, R>, features: &Features, t: R) -> R {
    if features.exact_order { t + ray.load(BOUNDS, 0) } else { t }
}

/// The state of a ray that goes to the state `tag` if its hit is certain.
pub(super) fn ended_with<R: Real>(ray: &Texels<'_, R>, features: &Features, tag: Tag, t: R) -> Tag {
    if !features.exact_order || (tag != SHADE && tag != BACKGROUND) {
        return tag;
    }
    let open: R = ray.load(BOUNDS, 1);
    if open <= latest_of(ray, features, t) && open < R::from_f32(INF) { EXACT } else { tag }
}
