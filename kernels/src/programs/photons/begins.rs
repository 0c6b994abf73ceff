//! Twin of `begins.wgsl`: a photon that begins to walk, from a light or from a surface.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::states::PHOTON_SETUP;
use crate::programs::closest_hit::streams::{
    PHOTON_AT, PHOTON_BOUNCE, PHOTON_DIRECTION, PHOTON_ORIGIN, PHOTON_POWER, PHOTON_STATE, PHOTON_SURFACE,
};
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::texels::Texels;

/// It has an origin, a direction and a power, and leaves a triangle, if any, after so many hits, which were all on mirrors and
/// glass or not.
pub(super) fn begin_way<R: Real>(
    photon: &mut Texels<'_, R>,
    [origin, direction, power]: [Vec3<R>; 3],
    leaves: u32,
    [hits, specular]: [u32; 2],
) {
    photon.store_vec3(PHOTON_ORIGIN, origin);
    photon.store_vec3(PHOTON_DIRECTION, direction);
    photon.store_vec3(PHOTON_POWER, power);
    photon.store_u32(PHOTON_SURFACE, 0, leaves);
    photon.store_u32(PHOTON_BOUNCE, 0, hits);
    photon.store_u32(PHOTON_BOUNCE, 1, specular);
    photon.store(PHOTON_AT, 0, R::zero());
    photon.store(PHOTON_AT, 1, R::zero());
    photon.store_u32(PHOTON_AT, 2, NO_TRIANGLE);
    photon.store(PHOTON_STATE, 1, R::from_f32(INF));
    photon.store_u32(PHOTON_STATE, 2, 0);
    photon.store_u32(PHOTON_STATE, 3, 0);
    photon.store_u32(PHOTON_STATE, 0, PHOTON_SETUP);
}
