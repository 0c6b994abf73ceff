//! Twin of `traverse_irregular.wgsl`: moves the ray to its next cell of the irregular grid.

use crate::numbers::real::Real;
use crate::programs::closest_hit::arrival::{arrive, leave};
use crate::programs::closest_hit::ray::{load_direction, load_origin, load_voxel, store_voxel};
use crate::programs::closest_hit::states::TRAV;
use crate::programs::closest_hit::streams::STATE;
use crate::scene_data::SceneData;
use crate::shared::irregular_walk::VoxelWalk;
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn traverse_irregular<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(STATE, 0) != TRAV {
        return;
    }

    let (irregular, features) = (scene.irregular(), &scene.features);
    let grid_ray = scene.grid.ray(features.walk_rules(), load_origin(ray), load_direction(ray));
    let left = VoxelWalk { voxel: load_voxel(ray), cell: ray.load_u32(STATE, 2), inside: true };
    let walk = irregular.step(&left, irregular.exit(&left, &grid_ray), &grid_ray);
    if !walk.inside {
        return leave(ray, features);
    }
    store_voxel(ray, walk.voxel);
    arrive(ray, features, walk.cell, irregular.exit(&walk, &grid_ray));
}
