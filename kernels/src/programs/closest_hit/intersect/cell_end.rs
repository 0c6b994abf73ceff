//! Twin of `cell_end.wgsl`: what follows when the list of a cell has ended.

use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::programs::closest_hit::grid_lists::list_ended;
use crate::programs::closest_hit::ray::load_interval;
use crate::programs::closest_hit::states::{BACKGROUND, TRAV};
use crate::programs::closest_hit::streams::TMAX;
use crate::shared::constants::INF;
use crate::shared::vector::smallest3;
use crate::tables::state::Tag;
use crate::tables::texels::Texels;

pub(super) fn after_cell<R: Real>(ray: &Texels<'_, R>, features: &Features, tag: Tag, nearest_t: R) -> Tag {
    if features.in_cell {
        return list_ended(features, tag, nearest_t, R::from_f32(INF));
    }
    let exit = smallest3(ray.load_vec3(TMAX));
    let next = list_ended(features, tag, nearest_t, exit);
    if features.intervals && next == TRAV && load_interval(ray, features)[1] <= exit {
        return BACKGROUND;
    }
    next
}
