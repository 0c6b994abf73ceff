//! Twin of `reflected.wgsl`: where a photon goes on from a surface, or that it is absorbed.

use crate::numbers::real::{Real, Vec3};
use crate::programs::light::optics::{optics_of, split_at};
use crate::programs::path::direction::cosine_weighted;
use crate::programs::path::random::{FOR_CHANCE, FOR_DIRECTION};
use crate::programs::path::scattered::{BY_ABSORPTION, BY_ROULETTE, BY_SURFACE, Next};
use crate::programs::path::vertex::Vertex;
use crate::scene_data::SceneData;
use crate::shared::shading::{DIFFUSE, MIRROR};
use crate::shared::start::{leaving, through};
use crate::shared::vector::{dot3, largest3};

/// Whether a triangle scatters light in all directions.
pub(super) fn is_diffuse(scene: &SceneData, triangle: u32) -> bool {
    !scene.features.specular || optics_of(scene, triangle).kind == DIFFUSE
}

/// Where a photon goes on from its hit.
pub(super) fn reflected_photon<R: Real>(at: &Vertex<'_, R>, scene: &SceneData) -> Next<R> {
    let (zero, one) = (R::zero(), R::one());
    let pair = |what| at.decided_after(scene, 1, what).map(R::from_f32);
    let chance = pair(FOR_CHANCE);
    let mut next = Next {
        origin: leaving(&at.start),
        direction: Vec3::splat(zero),
        throughput: Vec3::splat(zero),
        pdf: zero,
        ended: 0,
    };
    let mut albedo = at.color;
    if is_diffuse(scene, at.triangle) {
        next.direction = cosine_weighted(at.normal, pair(FOR_DIRECTION));
        if dot3(at.normal, next.direction) <= zero || dot3(at.start.normal, next.direction) <= zero {
            next.ended = BY_SURFACE;
        }
    } else {
        let optic = optics_of(scene, at.triangle);
        let split = split_at(optic, at.direction, at.normal, &at.start);
        next.direction = split.reflected;
        if optic.kind != MIRROR {
            if chance[0] < split.reflectance {
                albedo = Vec3::splat(one);
            } else {
                (next.origin, next.direction) = (through(&at.start), split.refracted);
            }
        }
    }
    let goes_on = largest3(albedo).min(one);
    #[allow(clippy::neg_cmp_op_on_partial_ord, reason = "as the WGSL has it: NaN is no albedo")]
    if !(goes_on > zero) {
        next.ended = BY_ABSORPTION;
        return next;
    }
    next.throughput = at.carried * (albedo * (one / goes_on)).map(|part| part.min(one));
    if chance[1] >= goes_on && next.ended == 0 {
        next.ended = BY_ROULETTE;
    }
    next
}
