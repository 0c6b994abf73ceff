//! Twin of `connected.wgsl`: the light that arrives at a vertex of a path.

use super::emitters::{pdf_by_area, share_of_hit, weight};
use super::toward::toward_emitter;
use super::vertex::Vertex;
use crate::numbers::real::{Real, Vec3};
use crate::programs::light::optics::optics_of;
use crate::scene_data::SceneData;
use crate::shared::constants::INF;
use crate::shared::shading::DIFFUSE;
use crate::shared::start::leaving;
use crate::shared::vector::{dot3, largest3, unit3};

/// 1 / π.
pub(in crate::programs) const INVERSE_PI: f32 = std::f32::consts::FRAC_1_PI;

/// What the surface emits along the path, by the pdf of the path's direction.
pub(super) fn emitted<R: Real>(at: &Vertex<'_, R>, scene: &SceneData, origin: Vec3<R>, of_direction: R) -> Vec3<R> {
    let material = at.material;
    if material.emissive == [0.0; 3] || at.start.is_back && material.double_sided == 0 {
        return Vec3::splat(R::zero());
    }
    let way = at.start.point - origin;
    let area: R = pdf_by_area(scene, material);
    let of_point = area * dot3(way, way) / dot3(at.start.normal, at.direction).abs();
    at.carried * Vec3::from_f32(material.emissive) * share_of_hit(&scene.features, of_direction, of_point)
}

/// A ray to an emitter.
pub(super) struct Connection<R> {
    pub(super) origin: Vec3<R>,
    pub(super) direction: Vec3<R>,
    /// The t at which it ends.
    pub(super) end: R,
    /// What reaches the pixel if nothing is in its way.
    pub(super) arrives: Vec3<R>,
    /// A light, or a triangle, as the table of emitters has it.
    pub(super) id: u32,
}

/// A ray to an emitter that is picked at random; `None` if nothing of its light can arrive.
pub(super) fn connected<R: Real>(at: &Vertex<'_, R>, scene: &SceneData) -> Option<Connection<R>> {
    let features = &scene.features;
    let is_diffuse = !features.specular || optics_of(scene, at.triangle).kind == DIFFUSE;
    if !features.shadows || at.depth >= features.depth || !is_diffuse {
        return None;
    }
    let origin = leaving(&at.start);
    let to = toward_emitter(at, scene, origin);
    let cosine = dot3(at.normal, unit3(to.direction));
    if !to.is_lit || cosine <= R::zero() || dot3(at.start.normal, to.direction) <= R::zero() {
        return None;
    }
    let of_direction = cosine * R::from_f32(INVERSE_PI);
    let mut arrives = to.light * (at.carried * at.color * of_direction);
    if features.mis && to.pdf > R::zero() {
        arrives = arrives * weight(to.pdf, of_direction);
    }
    let most = largest3(arrives);
    let is_cast = most > R::zero() && most < R::from_f32(INF);
    is_cast.then_some(Connection { origin, direction: to.direction, end: to.end, arrives, id: to.id })
}
