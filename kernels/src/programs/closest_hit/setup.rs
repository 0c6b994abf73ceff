//! Twin of `setup.wgsl`: finds where the ray's walk begins.

use crate::numbers::real::Real;
use crate::options::features::StructureKind;
use crate::programs::closest_hit::ray::{load_direction, load_origin, store_voxel};
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_NO_HIT, TRAV, TRAV_SETUP};
use crate::programs::closest_hit::streams::{BOUNDS, COUNTERS, PREVIOUS, STATE, TMAX, of_walk};
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_NODE};
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn setup<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(STATE, 0) != TRAV_SETUP {
        return;
    }
    let features = &scene.features;

    if features.exact_order {
        ray.store(BOUNDS, 0, R::zero());
        ray.store(BOUNDS, 1, R::from_f32(INF));
    }
    if features.counters {
        ray.store_u32(COUNTERS, 0, 0);
        ray.store_u32(COUNTERS, 1, 0);
        ray.store_u32(COUNTERS, 2, 0);
    }
    let mut next = ISECT_NO_HIT;
    match features.structure() {
        StructureKind::None => {}
        StructureKind::Grid => {
            let rules = features.walk_rules();
            let walk = scene.grid.enter(rules, &scene.grid.ray(rules, load_origin(ray), load_direction(ray)));
            if !walk.inside {
                ray.store_u32(STATE, 0, BACKGROUND);
                return;
            }
            if !(features.many_steps && features.keeps_no_tmax()) {
                ray.store_vec3(of_walk(features), walk.per_axis);
            }
            ray.store_u32(STATE, 2, scene.grid.cell_index(walk.cell));
            if features.counters {
                ray.store_u32(COUNTERS, 0, 1);
            }
        }
        StructureKind::Irregular => {
            let (irregular, rules) = (scene.irregular(), features.walk_rules());
            let grid_ray = scene.grid.ray(rules, load_origin(ray), load_direction(ray));
            let walk = irregular.enter(rules, &grid_ray);
            if !walk.inside {
                ray.store_u32(STATE, 0, BACKGROUND);
                return;
            }
            if !features.many_steps {
                ray.store_vec3(TMAX, irregular.exit(&walk, &grid_ray));
            }
            store_voxel(ray, walk.voxel);
            ray.store_u32(STATE, 2, walk.cell);
            if features.counters {
                ray.store_u32(COUNTERS, 0, 1);
            }
        }
        StructureKind::Bvh => {
            ray.store_u32(PREVIOUS, 0, NO_NODE);
            ray.store_u32(STATE, 2, 0);
            next = if scene.info.triangles == 0 { BACKGROUND } else { TRAV };
        }
    }
    ray.store_u32(STATE, 3, 0);
    ray.store_u32(STATE, 0, next);
}
