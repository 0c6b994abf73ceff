//! Twin of `scatter_photons.wgsl`: stores a photon where it has arrived, and sends it on, or ends it.

use super::begins::begin_way;
use super::emit_photons::sample_of;
use super::reflected::{is_diffuse, reflected_photon};
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::states::{PHOTON_ARRIVED, PHOTON_DONE, PHOTON_LEAVES};
use crate::programs::closest_hit::streams::{
    PHOTON_AT, PHOTON_BOUNCE, PHOTON_DIRECTION, PHOTON_ENERGY, PHOTON_POWER, PHOTON_RECORDS, PHOTON_STATE,
};
use crate::programs::path::scattered::{BY_DEPTH, BY_ESCAPE};
use crate::programs::path::vertex::Vertex;
use crate::scene_data::SceneData;
use crate::shared::constants::RECORD;
use crate::shared::vector::unit3;
use crate::tables::texels::Texels;

/// Layers of [`PHOTON_ENERGY`] with what surfaces have taken.
const ABSORBED: usize = 3;
/// Layers of [`PHOTON_ENERGY`] with what has left the scene.
const ESCAPED: usize = 6;

fn book_energy<R: Real>(photon: &mut Texels<'_, R>, first: usize, power: Vec3<R>) {
    for (layer, part) in (first..).zip(power.to_array()) {
        let before: R = photon.load(PHOTON_ENERGY, layer);
        photon.store(PHOTON_ENERGY, layer, before + part);
    }
}

/// The photon as it arrived, and why it ended there, or 0.
fn record<R: Real>(photon: &mut Texels<'_, R>, at: &Vertex<'_, R>, is_caustic: u32, ended: u32) {
    let first = ((at.depth - 1) * RECORD) as usize;
    for (layer, v) in [(first, at.start.point), (first + 3, at.direction), (first + 6, at.carried)] {
        for (layer, part) in (layer..).zip(v.to_array()) {
            photon.store(PHOTON_RECORDS, layer, part);
        }
    }
    photon.store_u32(PHOTON_RECORDS, first + 9, is_caustic);
    photon.store_u32(PHOTON_RECORDS, first + 10, ended);
}

fn end<R: Real>(photon: &mut Texels<'_, R>, why: u32) {
    photon.store_vec3(PHOTON_POWER, Vec3::splat(R::zero()));
    photon.store_u32(PHOTON_BOUNCE, 2, why);
    photon.store_u32(PHOTON_STATE, 0, PHOTON_DONE);
}

/// Processes one photon.
pub fn scatter_photons<R: Real>(photon: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = photon.load_u32(PHOTON_STATE, 0);
    if tag != PHOTON_ARRIVED && tag != PHOTON_LEAVES {
        return;
    }
    let power: Vec3<R> = photon.load_vec3(PHOTON_POWER);
    if tag == PHOTON_LEAVES {
        book_energy(photon, ESCAPED, power);
        return end(photon, BY_ESCAPE);
    }
    let [hits, specular] = [0, 1].map(|layer| photon.load_u32(PHOTON_BOUNCE, layer));
    let hit = (photon.load_u32(PHOTON_AT, 2), [photon.load(PHOTON_AT, 0), photon.load(PHOTON_AT, 1)]);
    let direction = unit3(photon.load_vec3(PHOTON_DIRECTION));
    let index = sample_of(photon, scene, photon.load_u32(PHOTON_BOUNCE, 3) - 1);
    let at = Vertex::new(photon, scene, hits, hit, direction, power).of_photon(index);
    let is_matte = is_diffuse(scene, at.triangle);
    let next = (hits + 1 < scene.features.depth).then(|| reflected_photon(&at, scene));
    let ended = next.as_ref().map_or(BY_DEPTH, |next| next.ended);
    if is_matte && hits > 0 {
        record(photon, &at, specular, ended);
    }
    let Some(next) = next.filter(|_| ended == 0) else {
        book_energy(photon, ABSORBED, power);
        return end(photon, ended);
    };
    book_energy(photon, ABSORBED, power - next.throughput);
    let specular = if is_matte { 0 } else { specular };
    begin_way(photon, [next.origin, next.direction, next.throughput], at.triangle, [hits + 1, specular]);
}
