//! Twin of `ray.wgsl`: the ray streams, as every kernel but `generate` reads them.

use crate::numbers::real::{Real, Vec3};
use crate::options::features::Features;
use crate::programs::closest_hit::streams;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::texels::Texels;

/// Origin of the ray, traced units.
#[must_use]
pub fn load_origin<R: Real>(ray: &Texels<'_, R>) -> Vec3<R> {
    ray.load_vec3(streams::RAY_ORIGIN)
}

/// The t between which hits count; neither end does. All t if no ray has an interval.
#[must_use]
pub fn load_interval<R: Real>(ray: &Texels<'_, R>, features: &Features) -> [R; 2] {
    if features.intervals {
        [ray.load(streams::RAY_INTERVAL, 0), ray.load(streams::RAY_INTERVAL, 1)]
    } else {
        [R::zero(), R::from_f32(INF)]
    }
}

/// The triangle that the ray leaves, if it begins on one.
#[must_use]
pub fn load_surface<R: Real>(ray: &Texels<'_, R>, features: &Features) -> u32 {
    if features.leaves { ray.load_u32(streams::SURFACE, 0) } else { NO_TRIANGLE }
}

/// The virtual cell by which the ray came into its cell of an irregular grid.
#[must_use]
pub fn load_voxel<R: Real>(ray: &Texels<'_, R>) -> [i32; 3] {
    [0, 1, 2].map(|layer| ray.load_u32(streams::VOXEL, layer) as i32)
}

/// Stores it.
pub fn store_voxel<R: Real>(ray: &mut Texels<'_, R>, voxel: [i32; 3]) {
    for (layer, v) in voxel.into_iter().enumerate() {
        ray.store_u32(streams::VOXEL, layer, v as u32);
    }
}

/// Direction of the ray, traced units per unit of t.
#[must_use]
pub fn load_direction<R: Real>(ray: &Texels<'_, R>) -> Vec3<R> {
    ray.load_vec3(streams::RAY_DIRECTION)
}
