//! Twin of `emission.wgsl`: where photons begin.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::shade::surface::material_of;
use crate::programs::path::connected::INVERSE_PI;
use crate::programs::path::direction::{cosine_weighted, on_circle, perpendicular};
use crate::programs::path::emitters::{cone_of, pdf_by_area, picked};
use crate::programs::path::random::{FOR_CHANCE, FOR_DIRECTION, FOR_EMITTER, FOR_POINT, OF_PHOTONS, decided_by};
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::emitters::PUNCTUAL;
use crate::shared::shading::{DIRECTIONAL, Light, SPOT};
use crate::shared::start::{leaving, start_of};
use crate::shared::vector::{cross3, dot3, unit3};

/// A photon as it is emitted.
pub(super) struct Emitted<R> {
    pub(super) origin: Vec3<R>,
    /// Length 1.
    pub(super) direction: Vec3<R>,
    pub(super) power: Vec3<R>,
    /// The triangle that it leaves.
    pub(super) leaves: u32,
}

/// A direction at an angle with this cosine to an axis of length 1.
fn about<R: Real>(axis: Vec3<R>, cosine: R, turns: R) -> Vec3<R> {
    let sine = (R::one() - cosine * cosine).max(R::zero()).sqrt();
    unit3(perpendicular(axis, on_circle(turns).map(|v| v * sine)) + axis * cosine)
}

/// The photon of this index.
pub(super) fn emitted_photon<R: Real>(scene: &SceneData, index: u32) -> Emitted<R> {
    let decided = |what| decided_by(scene.features.sampler(), scene.sampling.seed, OF_PHOTONS, index, 0, what);
    let emitter = picked(scene, decided(FOR_EMITTER));
    let toward = decided(FOR_DIRECTION).map(R::from_f32);
    let photons = R::from_f32(scene.photon_map.photons as f32);
    if emitter.id & PUNCTUAL != 0 {
        let light = &scene.lights[(emitter.id ^ PUNCTUAL) as usize];
        let share = R::one() / (photons * R::from_f32(emitter.chance));
        return of_light(scene, light, toward, Vec3::from_f32(light.color) * share);
    }
    let [a, b, c]: [Vec3<R>; 3] = scene.corners(emitter.id);
    let by = decided(FOR_POINT).map(R::from_f32);
    let side = by[0].sqrt();
    let material = material_of(scene, emitter.id);
    let is_double = material.double_sided != 0;
    let front = unit3(cross3(unit3(b - a), unit3(c - a)));
    let is_back = is_double && decided(FOR_CHANCE)[0] >= 0.5;
    let seen_along = if is_back { front } else { -front };
    let start = start_of([a, b, c], [side * (R::one() - by[1]), side * by[1]], seen_along);
    let of_point: R = pdf_by_area(scene, material);
    let sides = R::from_f32(if is_double { 2.0 } else { 1.0 });
    Emitted {
        origin: leaving(&start),
        direction: cosine_weighted(start.normal, toward),
        power: Vec3::from_f32(material.emissive) * (sides / (R::from_f32(INVERSE_PI) * photons * of_point)),
        leaves: emitter.id,
    }
}

/// A photon of a light without a size, by its intensity or illuminance and two random numbers.
fn of_light<R: Real>(scene: &SceneData, light: &Light, toward: [R; 2], power: Vec3<R>) -> Emitted<R> {
    let (one, two, inverse_pi) = (R::one(), R::from_f32(2.0), R::from_f32(INVERSE_PI));
    let (center, reach) = (Vec3::<R>::from_f32(scene.photon_map.center), R::from_f32(scene.photon_map.reach));
    let leaves = NO_TRIANGLE;
    if light.kind == DIRECTIONAL {
        let at = on_circle(toward[1]).map(|v| v * (toward[0].sqrt() * reach));
        let direction = unit3(Vec3::from_f32(light.direction));
        let origin = center + perpendicular(direction, at) - direction * reach;
        return Emitted { origin, direction, power: power * (reach * reach / inverse_pi), leaves };
    }
    let is_spot = scene.features.spot_lights && light.kind == SPOT;
    let (axis, least) = match is_spot {
        true => (unit3(Vec3::from_f32(light.direction)), R::from_f32(light.cos_outer)),
        false => (Vec3::from_f32([0.0, 0.0, 1.0]), -one),
    };
    let mut origin = Vec3::from_f32(light.position);
    let direction = about(axis, one - toward[0] * (one - least), toward[1]);
    let mut power = power * (two * (one - least) / inverse_pi);
    if is_spot {
        power = power * cone_of(light, -direction);
    }
    let ahead = dot3(center - origin, direction) - reach;
    if ahead > R::zero() {
        origin = origin + direction * ahead;
    }
    Emitted { origin, direction, power, leaves }
}
