//! Twin of `searches.wgsl`: searches for the photons of a map near a hit, how they begin, and the light that they have found.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::states::GATHER;
use crate::programs::closest_hit::streams::{GATHERED_POWER, GATHERING, SHRUNK, STATE};
use crate::programs::path::connected::INVERSE_PI;
use crate::scene_data::SceneData;
use crate::shared::constants::NO_CELL;
use crate::tables::texels::Texels;

/// Of the photons found in an iteration, the share that counts in the next.
const KEPT: f32 = 0.666_666_7;

/// The map of a pixel's latest search.
pub(super) fn map_of<R: Real>(ray: &Texels<'_, R>) -> u32 {
    ray.load_u32(GATHERING, 5)
}

/// Whether the pixel's ray was sent on from a diffuse surface.
pub(super) fn is_sent_on<R: Real>(ray: &Texels<'_, R>) -> u32 {
    ray.load_u32(GATHERING, 6)
}

pub(super) fn set_sent_on<R: Real>(ray: &mut Texels<'_, R>, is_sent: u32) {
    ray.store_u32(GATHERING, 6, is_sent);
}

/// Layers of [`SHRUNK`] that begin with those of a search.
fn slot(map: u32, is_sent: u32) -> usize {
    (4 * is_sent + 2 * map) as usize
}

/// The squared radius that earlier iterations have left, or 0.
fn radius_before<R: Real>(ray: &Texels<'_, R>, scene: &SceneData, map: u32, is_sent: u32) -> R {
    if scene.features.samples { ray.load(SHRUNK, slot(map, is_sent) + 1) } else { R::zero() }
}

/// Begins the search for photons of a map.
pub(super) fn begin_search<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, map: u32, is_sent: u32) {
    let radius = R::from_f32(scene.photon_map.radius);
    let before = radius_before(ray, scene, map, is_sent);
    let has_radius = before > R::zero();
    let limit = if has_radius { before } else { radius * radius };
    for (layer, word) in [NO_CELL, 0, 0, 0, u32::from(has_radius), map, is_sent, 0].into_iter().enumerate() {
        ray.store_u32(GATHERING, layer, word);
    }
    (0..GATHERED_POWER.layers()).for_each(|layer| ray.store(GATHERED_POWER, layer, R::zero()));
    ray.store(GATHERED_POWER, 0, limit);
    ray.store(GATHERED_POWER, 2, limit);
    ray.store_u32(STATE, 0, GATHER);
}

/// The flux by area that photons bring, by Jensen's cone filter; with several iterations, the radius shrinks.
pub(super) fn irradiance<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, map: u32, is_sent: u32) -> Vec3<R> {
    let (grid, f) = (&scene.photon_map, R::from_f32);
    let vec3 = |first: usize| Vec3::from([0, 1, 2].map(|part| ray.load(GATHERED_POWER, first + part)));
    let (power, weighted): (Vec3<R>, Vec3<R>) = (vec3(4), vec3(7));
    let whole = f(grid.radius) * f(grid.radius);
    let before = radius_before(ray, scene, map, is_sent);
    let found = ray.load_u32(GATHERING, 3);
    let of_search = if found >= grid.nearest { ray.load(GATHERED_POWER, 3) } else { whole };
    let squared = if before > R::zero() { before } else { of_search }.max(whole * f(1e-6));
    if scene.features.samples {
        let (slot, found) = (slot(map, is_sent), f(found as f32));
        let enough: R = ray.load(SHRUNK, slot);
        let kept = enough + f(KEPT) * found;
        ray.store(SHRUNK, slot, kept);
        let shrunk = if found > R::zero() { squared * (kept / (enough + found)) } else { squared };
        ray.store(SHRUNK, slot + 1, shrunk);
    }
    let left = power - weighted * (R::one() / squared.sqrt());
    left.map(|part| part.max(R::zero())) * (f(3.0 * INVERSE_PI) / squared)
}
