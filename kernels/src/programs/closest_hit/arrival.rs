//! Twin of `arrival.wgsl`: what a step from cell to cell leaves in the streams.

use crate::numbers::real::{Real, Vec3};
use crate::options::features::Features;
use crate::programs::closest_hit::bounds::ended_with;
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE};
use crate::programs::closest_hit::streams::{COUNTERS, STATE, of_walk};
use crate::shared::constants::INF;
use crate::tables::texels::Texels;

/// Whether the ray has a hit. One beyond the exit of its cell is kept; a later cell may hold a nearer one.
fn keeps_hit<R: Real>(ray: &Texels<'_, R>, features: &Features) -> bool {
    let nearest_t: R = ray.load(STATE, 1);
    !features.any_hit && nearest_t < R::from_f32(INF)
}

/// The ray has left the grid.
pub fn leave<R: Real>(ray: &mut Texels<'_, R>, features: &Features) {
    let ended = if keeps_hit(ray, features) { SHADE } else { BACKGROUND };
    ray.store_u32(STATE, 0, ended_with(ray, features, ended, ray.load(STATE, 1)));
}

/// The ray is in a cell; `per_axis` decides by which face it leaves it.
pub fn arrive<R: Real>(ray: &mut Texels<'_, R>, features: &Features, cell: u32, per_axis: Vec3<R>) {
    if features.counters {
        ray.store_u32(COUNTERS, 0, ray.load_u32(COUNTERS, 0) + 1);
    }
    ray.store_u32(STATE, 0, if keeps_hit(ray, features) { ISECT_HIT } else { ISECT_NO_HIT });
    ray.store_vec3(of_walk(features), per_axis);
    ray.store_u32(STATE, 2, cell);
    ray.store_u32(STATE, 3, 0);
}
