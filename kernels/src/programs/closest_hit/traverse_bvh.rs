//! Twin of `traverse_bvh.wgsl`: moves the ray to its next node of the BVH.

use crate::numbers::real::Real;
use crate::programs::closest_hit::bounds::{ended_with, latest_of};
use crate::programs::closest_hit::ray::{load_direction, load_interval, load_origin};
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::streams::{COUNTERS, PREVIOUS, STATE};
use crate::scene_data::SceneData;
use crate::shared::bvh_walk::{TreeRay, Visit, next_node};
use crate::shared::constants::{INF, NO_NODE};
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn traverse_bvh<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(STATE, 0) != TRAV {
        return;
    }
    let features = &scene.features;

    let (origin, direction) = (load_origin(ray), load_direction(ray));
    let tree_ray = TreeRay::new(origin, direction, features.ray_padding);
    let nearest_t: R = ray.load(STATE, 1);
    let has_hit = !features.any_hit && nearest_t < R::from_f32(INF);
    let here = Visit { node: ray.load_u32(STATE, 2), previous: ray.load_u32(PREVIOUS, 0), in_leaf: false };
    let farthest = latest_of(ray, features, nearest_t).min(load_interval(ray, features)[1]);
    let at = next_node(&scene.bvh_nodes, &scene.bvh_parents, here, &tree_ray, farthest);

    if features.counters {
        ray.store_u32(COUNTERS, 0, ray.load_u32(COUNTERS, 0) + 1);
    }
    if at.node == NO_NODE {
        let ended = if has_hit { SHADE } else { BACKGROUND };
        ray.store_u32(STATE, 0, ended_with(ray, features, ended, nearest_t));
        return;
    }
    let tag = match (at.in_leaf, has_hit) {
        (false, _) => TRAV,
        (true, false) => ISECT_NO_HIT,
        (true, true) => ISECT_HIT,
    };
    ray.store_u32(STATE, 0, tag);
    ray.store_u32(STATE, 2, at.node);
    ray.store_u32(STATE, 3, 0);
    ray.store_u32(PREVIOUS, 0, at.previous);
}
