//! Twin of `key_photons.wgsl`: the cell of each place where a photon is stored.

use crate::numbers::real::Vec3;
use crate::scene_data::SceneData;
use crate::shared::constants::{NO_CELL, RECORD};
use crate::shared::photon_map::PhotonMap;
use crate::tables::stream::Stream;
use crate::tables::texels::Columns;

/// The photon that a record is of, and the first of its layers.
pub(super) fn place_of(map: &PhotonMap, record: u32) -> (usize, usize) {
    let (photon, bounce) = map.photon_of(record);
    (photon as usize, (bounce * RECORD) as usize)
}

/// Three floats of a photon's records, from a layer on.
pub(super) fn load_vec3(columns: &dyn Columns, records: Stream, layer: usize, photon: usize) -> Vec3<f32> {
    Vec3::from([0, 1, 2].map(|axis| f32::from_bits(columns.load(records, layer + axis, photon))))
}

/// Runs a pass.
pub fn key_photons(columns: &mut dyn Columns, scene: &SceneData) {
    let Some((records, key)) = columns.stream("photon_records").zip(columns.stream("photon_key")) else { return };
    let map = &scene.photon_map;
    for i in 0..columns.len(key) {
        let (photon, first) = place_of(map, i as u32);
        let cell = match columns.load(records, first + 9, photon) {
            NO_CELL => NO_CELL,
            of => {
                let at = map.cell_of(map.place_of(load_vec3(columns, records, first, photon)));
                map.index_of(of.min(map.maps - 1), at)
            }
        };
        columns.store(key, 0, i, cell);
        columns.store(key, 1, i, i as u32);
    }
}
