//! Twin of `traverse_grid.wgsl`: moves the ray to its next cell.

use crate::executor::cpu::Texels;
use crate::real::Real;
use crate::scene_data::SceneData;
use crate::shared::constants::INF;
use crate::shared::grid_walk::Walk;
use crate::state::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::stream::Stream::{Counters, RayDirection, RayOrigin, State, TMax};

/// One ray's work.
pub fn traverse_grid<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(State, 0) != TRAV {
        return;
    }

    let cell = scene.grid.cell_of_index(ray.load_u32(State, 2));
    let here = Walk { cell, tmax: ray.load_vec3(TMax), inside: true };
    let rules = scene.features.walk_rules();
    let next = scene.grid.advance(rules, here, ray.load_vec3(RayOrigin), ray.load_vec3(RayDirection));
    // A hit beyond the cell's exit is kept; a later cell may hold a nearer one.
    let has_hit = ray.load(State, 1) < R::from_f32(INF);

    if !next.inside {
        ray.store_u32(State, 0, if has_hit { SHADE } else { BACKGROUND });
        return;
    }
    ray.store_vec3(TMax, next.tmax);
    ray.store_u32(State, 0, if has_hit { ISECT_HIT } else { ISECT_NO_HIT });
    ray.store_u32(State, 2, scene.grid.cell_index(next.cell));
    ray.store_u32(State, 3, 0);
    if scene.features.counters {
        ray.store_u32(Counters, 0, ray.load_u32(Counters, 0) + 1);
    }
}
