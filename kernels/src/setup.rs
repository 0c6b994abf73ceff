//! Twin of `setup.wgsl`: finds the ray's first cell.

use crate::executor::cpu::Texels;
use crate::real::Real;
use crate::scene_data::SceneData;
use crate::state::{BACKGROUND, ISECT_NO_HIT, TRAV_SETUP};
use crate::stream::Stream::{Counters, RayDirection, RayOrigin, State, TMax};

/// One ray's work.
pub fn setup<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(State, 0) != TRAV_SETUP {
        return;
    }
    let features = &scene.features;

    if features.counters {
        ray.store_u32(Counters, 0, 0);
        ray.store_u32(Counters, 1, 0);
        ray.store_u32(Counters, 2, 0);
    }
    if features.grid {
        let walk = scene.grid.enter(features.walk_rules(), ray.load_vec3(RayOrigin), ray.load_vec3(RayDirection));
        if !walk.inside {
            ray.store_u32(State, 0, BACKGROUND);
            return;
        }
        ray.store_vec3(TMax, walk.tmax);
        ray.store_u32(State, 2, scene.grid.cell_index(walk.cell));
        if features.counters {
            ray.store_u32(Counters, 0, 1);
        }
    }
    ray.store_u32(State, 0, ISECT_NO_HIT);
    ray.store_u32(State, 3, 0);
}
