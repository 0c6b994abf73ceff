//! Twin of `traverse_grid.wgsl`: moves the ray to its next cell.

use crate::numbers::real::Real;
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::streams::{COUNTERS, STATE, TMAX};
use crate::scene_data::SceneData;
use crate::shared::constants::INF;
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
    let nearest_t: R = ray.load(STATE, 1);
    // A hit beyond the cell's exit is kept; a later cell may hold a nearer one.
    let has_hit = !features.any_hit && nearest_t < R::from_f32(INF);
    let index = ray.load_u32(STATE, 2);
    let here = Walk { cell: grid.cell_of_index(index), tmax: ray.load_vec3(TMAX), inside: true };
    let walk = if features.skip {
        grid.leap(here, scene.empty_distance(index).max(1), &grid_ray)
    } else {
        grid.advance(rules, here, &grid_ray)
    };

    if !walk.inside {
        ray.store_u32(STATE, 0, if has_hit { SHADE } else { BACKGROUND });
        return;
    }
    if features.counters {
        ray.store_u32(COUNTERS, 0, ray.load_u32(COUNTERS, 0) + 1);
    }
    ray.store_u32(STATE, 0, if has_hit { ISECT_HIT } else { ISECT_NO_HIT });
    ray.store_vec3(TMAX, walk.tmax);
    ray.store_u32(STATE, 2, grid.cell_index(walk.cell));
    ray.store_u32(STATE, 3, 0);
}
