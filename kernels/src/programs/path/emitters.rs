//! Twin of `emitters.wgsl`: what gives light.

use crate::numbers::real::{Real, Vec3};
use crate::options::features::Features;
use crate::scene_data::SceneData;
use crate::shared::emitters::{Emitter, LUMINANCE};
use crate::shared::shading::{Light, Material};
use crate::shared::vector::dot3;

/// By a pair of numbers from 0 to below 1.
pub(in crate::programs) fn picked(scene: &SceneData, [x, y]: [f32; 2]) -> Emitter {
    let count = scene.emission.count;
    let emitter = scene.emitters[((x * count as f32) as u32).min(count - 1) as usize];
    if y < emitter.keep { emitter } else { scene.emitters[emitter.other as usize] }
}

/// The pdf of a point of a triangle, by area.
pub(in crate::programs) fn pdf_by_area<R: Real>(scene: &SceneData, material: &Material) -> R {
    let luminance = dot3(Vec3::<R>::from_f32(material.emissive), Vec3::from_f32(LUMINANCE));
    let sides = R::from_f32(if material.double_sided != 0 { 2.0 } else { 1.0 });
    luminance * R::from_f32(scene.emission.per_luminance) * sides
}

/// The weight of a sample by one of two strategies (Veach and Guibas 1995): their power heuristic, by squares.
pub(in crate::programs) fn weight<R: Real>(pdf: R, other: R) -> R {
    let ratio = other / pdf;
    R::one() / (R::one() + ratio * ratio)
}

/// The share of the light that counts where a path hits a triangle by chance, with the pdfs of its direction and of that
/// point, by solid angle. Without a pdf, there was one direction.
pub(in crate::programs) fn share_of_hit<R: Real>(features: &Features, of_direction: R, of_point: R) -> R {
    match of_direction == R::zero() {
        false if features.mis => weight(of_direction, of_point),
        false if features.by_light => R::zero(),
        _ => R::one(),
    }
}

/// What arrives from a spot along a direction of length 1, as a share of its intensity.
pub(in crate::programs) fn cone_of<R: Real>(light: &Light, towards: Vec3<R>) -> R {
    let cosine = dot3(-towards, Vec3::from_f32(light.direction));
    let cone = (cosine - R::from_f32(light.cos_outer)) * R::from_f32(light.cone_scale);
    let cone = cone.max(R::zero()).min(R::one());
    cone * cone
}
