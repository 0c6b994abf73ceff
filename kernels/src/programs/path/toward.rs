//! Twin of `toward.wgsl`: the way from a point to an emitter that is picked at random.

use super::emitters::{cone_of, pdf_by_area, picked};
use super::random::{FOR_EMITTER, FOR_POINT};
use super::vertex::Vertex;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::shade::surface::material_of;
use crate::scene_data::SceneData;
use crate::shared::constants::INF;
use crate::shared::emitters::PUNCTUAL;
use crate::shared::shading::{DIRECTIONAL, SPOT};
use crate::shared::start::end_before;
use crate::shared::vector::{cross3, dot3, unit3};

/// The way to an emitter.
pub(super) struct Toward<R> {
    /// A light, or a triangle, as the table has it.
    pub(super) id: u32,
    /// To a point at t = 1, or against the direction of a light without a place.
    pub(super) direction: Vec3<R>,
    /// The t at which a shadow ray ends.
    pub(super) end: R,
    /// Radiance by the pdf; of a light without a size, its illuminance by the probability that it was picked.
    pub(super) light: Vec3<R>,
    /// By solid angle; 0 without a size.
    pub(super) pdf: R,
    /// The side of a triangle glows that is seen.
    pub(super) is_lit: bool,
}

/// Picks an emitter, and a point of it.
pub(super) fn toward_emitter<R: Real>(at: &Vertex<'_, R>, scene: &SceneData, origin: Vec3<R>) -> Toward<R> {
    let features = &scene.features;
    let emitter = picked(scene, at.decided_by(scene, FOR_EMITTER));
    let zero = R::zero();
    let mut to = Toward {
        id: emitter.id,
        direction: Vec3::splat(zero),
        end: R::from_f32(INF),
        light: Vec3::splat(zero),
        pdf: zero,
        is_lit: true,
    };
    if emitter.id & PUNCTUAL != 0 {
        let light = &scene.lights[(emitter.id ^ PUNCTUAL) as usize];
        to.light = Vec3::from_f32(light.color) * (R::one() / R::from_f32(emitter.chance));
        to.direction = -Vec3::<R>::from_f32(light.direction);
        if light.kind != DIRECTIONAL {
            let position = Vec3::from_f32(light.position);
            to.direction = position - origin;
            to.end = end_before(position, to.direction);
            to.light = to.light * (R::one() / dot3(to.direction, to.direction));
        }
        if features.spot_lights && light.kind == SPOT {
            to.light = to.light * cone_of(light, unit3(to.direction));
        }
        return to;
    }
    if features.emissive {
        let [a, b, c]: [Vec3<R>; 3] = scene.corners(emitter.id);
        let (ab, ac) = (b - a, c - a);
        let by = at.decided_by(scene, FOR_POINT).map(R::from_f32);
        let side = by[0].sqrt();
        let point = a + (ab * (side * (R::one() - by[1])) + ac * (side * by[1]));
        to.direction = point - origin;
        to.end = end_before(point, to.direction);
        let material = material_of(scene, emitter.id);
        let facing = -dot3(unit3(cross3(unit3(ab), unit3(ac))), unit3(to.direction));
        let cosine = if material.double_sided != 0 { facing.abs() } else { facing };
        to.is_lit = cosine > zero;
        let area: R = pdf_by_area(scene, material);
        to.pdf = area * dot3(to.direction, to.direction) / cosine;
        to.light = Vec3::from_f32(material.emissive) * (R::one() / to.pdf);
    }
    to
}
