//! Twin of `ray.wgsl`: the ray streams, as every kernel but `generate` reads them.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::streams;
use crate::tables::texels::Texels;

/// Origin of the ray, traced units.
#[must_use]
pub fn load_origin<R: Real>(ray: &Texels<'_, R>) -> Vec3<R> {
    ray.load_vec3(streams::RAY_ORIGIN)
}

/// Direction of the ray, traced units per unit of t.
#[must_use]
pub fn load_direction<R: Real>(ray: &Texels<'_, R>) -> Vec3<R> {
    ray.load_vec3(streams::RAY_DIRECTION)
}
