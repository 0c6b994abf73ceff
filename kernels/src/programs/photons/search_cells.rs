//! Twin of `search_cells.wgsl`: where the list of each cell begins among the sorted keys.

use crate::programs::primitives::{load, store};
use crate::scene_data::SceneData;
use crate::tables::texels::Columns;

/// Runs a pass.
pub fn search_cells(columns: &mut dyn Columns, scene: &SceneData) {
    let keys = load(columns, "photon_key", 0);
    let keys = &keys[..keys.len().min(scene.photon_map.records as usize)];
    let Some(first) = columns.stream("photon_first") else { return };
    let cells = columns.len(first) as u32;
    store(columns, "photon_first", 0, (0..cells).map(|cell| keys.partition_point(|&key| key < cell) as u32));
}
