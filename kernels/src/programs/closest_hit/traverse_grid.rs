//! Twin of `traverse_grid.wgsl`: moves the ray to its next cell.

use crate::numbers::real::Real;
use crate::programs::closest_hit::arrival::{arrive, leave};
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::states::TRAV;
use crate::programs::closest_hit::streams::{STATE, of_walk};
use crate::scene_data::SceneData;
use crate::shared::grid_walk::Walk;
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn traverse_grid<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(STATE, 0) != TRAV {
        return;
    }

    let (grid, features) = (&scene.grid, &scene.features);
    let rules = features.walk_rules();
    let grid_ray = grid.ray(rules, load_origin(ray), load_direction(ray));
    let index = ray.load_u32(STATE, 2);
    let here = Walk { cell: grid.cell_of_index(index), per_axis: ray.load_vec3(of_walk(features)), inside: true };
    let walk = if features.skip {
        grid.leap(here, scene.empty_distance(index).max(1), &grid_ray)
    } else {
        grid.advance(rules, here, &grid_ray)
    };
    if !walk.inside {
        return leave(ray, features);
    }
    arrive(ray, features, grid.cell_index(walk.cell), walk.per_axis);
}
