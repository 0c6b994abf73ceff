//! Twin of `scattered.wgsl`: where a path goes on from a vertex, in a direction that the surface's BSDF decides.

use super::connected::INVERSE_PI;
use super::direction::cosine_weighted;
use super::random::{FOR_CHANCE, FOR_DIRECTION};
use super::vertex::Vertex;
use crate::numbers::real::{Real, Vec3};
use crate::programs::light::optics::{optics_of, split_at};
use crate::scene_data::SceneData;
use crate::shared::shading::{DIFFUSE, MIRROR};
use crate::shared::start::{leaving, through};
use crate::shared::vector::{dot3, largest3};

/// Bounces before a path may end by chance.
pub(in crate::programs) const ROULETTE_DEPTH: u32 = 3;
/// The largest chance to go on.
const MOST_CHANCE: f32 = 0.95;

/// Why a path ended: nothing was hit.
pub(in crate::programs) const BY_ESCAPE: u32 = 1;
/// It has as many bounces as it may have.
pub(in crate::programs) const BY_DEPTH: u32 = 2;
/// The surface reflects nothing.
pub(in crate::programs) const BY_ABSORPTION: u32 = 3;
/// The direction leads below the triangle, whose interpolated normal is another one.
pub(in crate::programs) const BY_SURFACE: u32 = 4;
/// By chance.
pub(in crate::programs) const BY_ROULETTE: u32 = 5;

/// Where a path goes on.
pub(in crate::programs) struct Next<R> {
    pub(in crate::programs) origin: Vec3<R>,
    pub(in crate::programs) direction: Vec3<R>,
    /// What it carries.
    pub(in crate::programs) throughput: Vec3<R>,
    /// The pdf of the direction, by solid angle; 0 if there was no other.
    pub(in crate::programs) pdf: R,
    /// Why it ends instead, or 0.
    pub(in crate::programs) ended: u32,
}

/// Where a path goes on from a vertex.
pub(in crate::programs) fn scattered<R: Real>(at: &Vertex<'_, R>, scene: &SceneData) -> Next<R> {
    let pair = |what| at.decided_by(scene, what).map(R::from_f32);
    let chance = pair(FOR_CHANCE);
    let mut next = Next {
        origin: leaving(&at.start),
        direction: at.direction,
        throughput: at.carried * at.color,
        pdf: R::zero(),
        ended: 0,
    };
    let optic = scene.features.specular.then(|| optics_of(scene, at.triangle)).filter(|optic| optic.kind != DIFFUSE);
    if let Some(optic) = optic {
        let split = split_at(optic, at.direction, at.normal, &at.start);
        next.direction = split.reflected;
        if optic.kind != MIRROR {
            if chance[0] < split.reflectance {
                next.throughput = at.carried;
            } else {
                (next.origin, next.direction) = (through(&at.start), split.refracted);
            }
        }
    } else {
        next.direction = cosine_weighted(at.normal, pair(FOR_DIRECTION));
        next.pdf = dot3(at.normal, next.direction) * R::from_f32(INVERSE_PI);
        if next.pdf <= R::zero() || dot3(at.start.normal, next.direction) <= R::zero() {
            next.ended = BY_SURFACE;
        }
    }
    let most = largest3(next.throughput);
    if most > R::zero() {
        if at.depth >= ROULETTE_DEPTH {
            let goes_on = most.min(R::from_f32(MOST_CHANCE));
            next.throughput = next.throughput * (R::one() / goes_on);
            if chance[1] >= goes_on && next.ended == 0 {
                next.ended = BY_ROULETTE;
            }
        }
    } else {
        next.ended = BY_ABSORPTION;
    }
    next
}
