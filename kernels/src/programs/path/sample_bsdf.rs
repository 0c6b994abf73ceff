//! Twin of `sample_bsdf.wgsl`: adds what the shadow ray brought, and sends the path on, or ends it.

use super::at_hit::{cost_of_shadow, end, go_on, light_so_far, vertex_of_hit};
use super::scattered::{BY_DEPTH, BY_ESCAPE, scattered};
use crate::numbers::real::Real;
use crate::programs::closest_hit::states::{OCCLUDED, SCATTER, VISIBLE};
use crate::programs::closest_hit::streams::{BOUNCE, HIT, STATE};
use crate::programs::light::bounced::{carried_at, spend};
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn sample_bsdf<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if tag != SCATTER && tag != OCCLUDED && tag != VISIBLE {
        return;
    }
    let depth = ray.load_u32(BOUNCE, 0);
    let carried = carried_at(ray, depth);
    let sum = light_so_far(ray, scene, tag);
    let triangle = ray.load_u32(HIT, 2);
    let is_hit = triangle != NO_TRIANGLE;
    let next = (is_hit && depth < scene.features.depth)
        .then(|| scattered(&vertex_of_hit(ray, scene, depth, triangle, carried), scene));
    let ended = match &next {
        Some(next) => next.ended,
        None if is_hit => BY_DEPTH,
        None => BY_ESCAPE,
    };
    if scene.features.counters {
        spend(ray, cost_of_shadow(ray, scene, tag), depth == 0, ended != 0);
    }
    match next {
        Some(next) if ended == 0 => go_on(ray, &next, triangle, depth),
        _ => end(ray, ended, sum),
    }
}
