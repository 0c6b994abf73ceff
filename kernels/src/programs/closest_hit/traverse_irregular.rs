//! Twin of `traverse_irregular.wgsl`: moves the ray to its next cell of the irregular grid.

use crate::numbers::real::Real;
use crate::programs::closest_hit::ray::{load_direction, load_origin, load_voxel, store_voxel};
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::streams::{COUNTERS, STATE, TMAX};
use crate::scene_data::SceneData;
use crate::shared::constants::INF;
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn traverse_irregular<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(STATE, 0) != TRAV {
        return;
    }

    let features = &scene.features;
    let grid_ray = scene.grid.ray(features.walk_rules(), load_origin(ray), load_direction(ray));
    let nearest_t: R = ray.load(STATE, 1);
    // A hit beyond the box's exit is kept; a later cell may hold a nearer one.
    let has_hit = !features.any_hit && nearest_t < R::from_f32(INF);
    let irregular = scene.irregular();
    let walk = irregular.step(&irregular.at(load_voxel(ray), ray.load_u32(STATE, 2), &grid_ray), &grid_ray);

    if !walk.inside {
        ray.store_u32(STATE, 0, if has_hit { SHADE } else { BACKGROUND });
        return;
    }
    if features.counters {
        ray.store_u32(COUNTERS, 0, ray.load_u32(COUNTERS, 0) + 1);
    }
    ray.store_u32(STATE, 0, if has_hit { ISECT_HIT } else { ISECT_NO_HIT });
    ray.store_vec3(TMAX, walk.tmax);
    store_voxel(ray, walk.voxel);
    ray.store_u32(STATE, 2, walk.cell);
    ray.store_u32(STATE, 3, 0);
}
