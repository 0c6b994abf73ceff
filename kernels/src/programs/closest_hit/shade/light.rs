//! Twin of `light.wgsl`: the light that a point receives.

use crate::numbers::real::{Real, Vec3};
use crate::shared::shading::{DIRECTIONAL, Light, SPOT};
use crate::shared::vector::{dot3, unit3};

/// <N, L> of one light times its colour.
pub(in crate::programs) fn received<R: Real>(light: &Light, position: Vec3<R>, normal: Vec3<R>) -> Vec3<R> {
    let color = Vec3::<R>::from_f32(light.color);
    let direction = Vec3::<R>::from_f32(light.direction);
    let zero = R::zero();
    if light.kind == DIRECTIONAL {
        return color * dot3(normal, -direction).max(zero);
    }
    let to_light = unit3(Vec3::from_f32(light.position) - position);
    let amount = dot3(normal, to_light).max(zero);
    if light.kind == SPOT {
        let cone = (dot3(-to_light, direction) - R::from_f32(light.cos_outer)) * R::from_f32(light.cone_scale);
        let cone = cone.max(zero).min(R::one());
        return color * (amount * cone * cone);
    }
    color * amount
}
