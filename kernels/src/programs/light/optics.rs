//! Twin of `optics.wgsl`: how a smooth surface reflects and refracts light.

use crate::numbers::real::{Real, Vec3};
use crate::scene_data::SceneData;
use crate::shared::shading::{MIRROR, Optics, SHEET};
use crate::shared::start::Start;
use crate::shared::vector::dot3;

/// What a surface sends on of light that arrives along a direction: reversed, what a ray sees there.
#[derive(Clone, Copy, Debug)]
pub(in crate::programs) struct Split<R> {
    /// Direction of length 1.
    pub(in crate::programs) reflected: Vec3<R>,
    /// Direction of length 1.
    pub(in crate::programs) refracted: Vec3<R>,
    /// The share of the light that is reflected.
    pub(in crate::programs) reflectance: R,
}

/// How a triangle's material scatters light.
pub(in crate::programs) fn optics_of(scene: &SceneData, triangle: u32) -> Optics {
    let index = if scene.features.many_materials { scene.triangle_materials[triangle as usize] } else { 0 };
    scene.optics[index as usize]
}

/// Splits light along a direction of length 1 at a surface whose normal is on its side. `is_back`: the light is inside.
fn split<R: Real>(of: Optics, direction: Vec3<R>, normal: Vec3<R>, is_back: bool) -> Split<R> {
    let (zero, one) = (R::zero(), R::one());
    let cosine = (-dot3(normal, direction)).max(zero);
    let reflected = direction + normal * (R::from_f32(2.0) * cosine);
    if of.kind == MIRROR || cosine == zero {
        return Split { reflected, refracted: direction, reflectance: one };
    }
    let ior = R::from_f32(of.ior);
    let ratio = if is_back && of.kind != SHEET { ior } else { one / ior };
    let square = one - ratio * ratio * (one - cosine * cosine);
    if square <= zero {
        return Split { reflected, refracted: direction, reflectance: one };
    }
    let cosine_beyond = square.sqrt();
    let across = (ratio * cosine - cosine_beyond) / (ratio * cosine + cosine_beyond);
    let along = (cosine - ratio * cosine_beyond) / (cosine + ratio * cosine_beyond);
    let reflectance = R::from_f32(0.5) * (across * across + along * along);
    let refracted =
        if of.kind == SHEET { direction } else { direction * ratio + normal * (ratio * cosine - cosine_beyond) };
    Split { reflected, refracted, reflectance }
}

/// The same at a point of a triangle, by an interpolated normal on its side, unless that would lead a ray to the wrong side
/// of the triangle.
pub(in crate::programs) fn split_at<R: Real>(
    of: Optics,
    direction: Vec3<R>,
    normal: Vec3<R>,
    start: &Start<R>,
) -> Split<R> {
    let at = split(of, direction, normal, start.is_back);
    if dot3(at.reflected, start.normal) <= R::zero() || dot3(at.refracted, start.normal) >= R::zero() {
        return split(of, direction, start.normal, start.is_back);
    }
    at
}
