//! Twin of `ray.wgsl`: the ray streams, as every kernel but `generate` reads them.

use crate::numbers::real::{Real, Vec3};
use crate::tables::stream::Stream;
use crate::tables::texels::Texels;

/// Where the ray starts, traced units.
#[must_use]
pub fn load_origin<R: Real>(ray: &Texels<'_, R>) -> Vec3<R> {
    ray.load_vec3(Stream::RayOrigin)
}

/// Where it goes, traced units per unit of t.
#[must_use]
pub fn load_direction<R: Real>(ray: &Texels<'_, R>) -> Vec3<R> {
    ray.load_vec3(Stream::RayDirection)
}
