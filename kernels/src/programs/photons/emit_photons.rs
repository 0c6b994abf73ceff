//! Twin of `emit_photons.wgsl`: emits every photon.

use super::begins::begin_way;
use super::emission::emitted_photon;
use crate::numbers::real::Real;
use crate::programs::closest_hit::states::{PHOTON_DONE, PHOTON_UNBORN};
use crate::programs::closest_hit::streams::{PHOTON_BOUNCE, PHOTON_ENERGY, PHOTON_RECORDS, PHOTON_STATE};
use crate::scene_data::SceneData;
use crate::shared::constants::{NO_CELL, RECORD};
use crate::tables::texels::Texels;

/// Which of all photons this is after so many emissions: they are samples of one sequence.
pub(super) fn sample_of<R: Real>(photon: &Texels<'_, R>, scene: &SceneData, emissions: u32) -> u32 {
    let map = &scene.photon_map;
    emissions.wrapping_mul(map.photons).wrapping_add(photon.y * map.row + photon.x)
}

/// Processes one photon.
pub fn emit_photons<R: Real>(photon: &mut Texels<'_, R>, scene: &SceneData) {
    if ![PHOTON_UNBORN, PHOTON_DONE].contains(&photon.load_u32(PHOTON_STATE, 0)) {
        return;
    }
    let emissions = photon.load_u32(PHOTON_BOUNCE, 3);
    let emitted = emitted_photon(scene, sample_of(photon, scene, emissions));
    photon.store_vec3(PHOTON_ENERGY, emitted.power);
    for layer in 3..9 {
        photon.store(PHOTON_ENERGY, layer, R::zero());
    }
    for record in 0..scene.features.depth.saturating_sub(1) {
        photon.store_u32(PHOTON_RECORDS, (record * RECORD + 9) as usize, NO_CELL);
    }
    photon.store_u32(PHOTON_BOUNCE, 2, 0);
    photon.store_u32(PHOTON_BOUNCE, 3, emissions + 1);
    begin_way(photon, [emitted.origin, emitted.direction, emitted.power], emitted.leaves, [0, 1]);
}
