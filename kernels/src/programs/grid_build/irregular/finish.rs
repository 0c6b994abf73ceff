//! Twins of the kernels that expand cells, and write the buffers that rays read.

use super::map::VoxelMap;
use super::merge::is_listed;
use super::pass::{Pass, View, high_of, low_of};
use crate::scene_data::SceneData;
use crate::shared::constants::{LAST_ITEM, NO_LIST};
use crate::shared::irregular_walk::cell_entry;
use crate::structures::irregular::expand::{MOST_LOOKED_AT, ROUNDS};
use crate::tables::texels::Columns;

/// A leaf whose box is being expanded.
struct Growing<'a, 'p> {
    pass: &'a Pass<'p>,
    map: &'a VoxelMap,
    space: View,
    list: View,
    item: View,
    first: u32,
    listed: u32,
    seen: u32,
}

impl Growing<'_, '_> {
    /// Whether the leaf's list has every triangle of another one's.
    fn has_all_of(&mut self, other: u32) -> bool {
        let [first, listed] = self.pass.all(self.list, other);
        if listed > self.listed {
            self.seen += 1;
            return false;
        }
        self.seen += 1 + listed.min(MOST_LOOKED_AT);
        self.seen <= MOST_LOOKED_AT
            && (0..listed).all(|k| {
                let triangle = self.pass.get(self.item, 0, first.wrapping_add(k));
                is_listed(self.pass, self.item, self.first, self.listed, triangle)
            })
    }

    /// By how much a face can be moved.
    fn layer(&mut self, low: [u32; 3], high: [u32; 3], axis: usize, is_up: bool) -> u32 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut at = low;
        at[axis] = if is_up { high[axis] } else { low[axis] - 1 };
        let mut depth = u32::MAX;
        while at[v] < high[v] {
            let mut next_row = high[v];
            at[u] = low[u];
            while at[u] < high[u] {
                let other = self.map.find(self.pass, at);
                if !self.has_all_of(other) {
                    return 0;
                }
                let extent = self.pass.all::<3>(self.space, other);
                let (first, end) = (low_of(extent[axis]), high_of(extent[axis]));
                let reach = if is_up { end.wrapping_sub(at[axis]) } else { (at[axis] + 1).wrapping_sub(first) };
                depth = depth.min(reach);
                next_row = next_row.min(high_of(extent[v]));
                // If somebody has edited a box, there must be no endless loop.
                at[u] = high_of(extent[u]).max(at[u] + 1);
            }
            at[v] = next_row.max(at[v] + 1);
        }
        depth
    }
}

pub(crate) fn expand(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [space, list, item, expanded] = ["space", "list", "item", "expanded"].map(|name| pass.of(name));
    let map = VoxelMap::new(&pass);
    let end = data.build.cells.map(|n| n << data.build.levels);
    for i in 0..pass.len(space) {
        let extent = pass.all::<3>(space, i);
        let (mut low, mut high) = (extent.map(low_of), extent.map(high_of));
        let [first, listed] = pass.all(list, i);
        let mut leaf = Growing { pass: &pass, map: &map, space, list, item, first, listed, seen: 0 };
        let mut stopped = [[false; 2]; 3];
        for _ in 0..ROUNDS {
            let before = (low, high);
            for (axis, [down, up]) in stopped.iter_mut().enumerate() {
                if !*up && high[axis] < end[axis] {
                    let by = leaf.layer(low, high, axis, true);
                    high[axis] = high[axis].wrapping_add(by);
                    *up = by == 0;
                }
                if !*down && low[axis] > 0 {
                    let by = leaf.layer(low, high, axis, false);
                    low[axis] = low[axis].wrapping_sub(by);
                    *down = by == 0;
                }
            }
            if (low, high) == before || leaf.seen > MOST_LOOKED_AT {
                break;
            }
        }
        pass.set_all(expanded, i, [0, 1, 2].map(|a| low[a] | high[a] << 16));
    }
}

pub(crate) fn name_cells(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let (cell_of, map) = (pass.of("cell_of"), pass.of("map_entries"));
    for i in 0..pass.len(map) {
        let entry = pass.get(map, 0, i);
        if entry & 3 == 0 {
            pass.set(map, 0, i, cell_entry(pass.get(cell_of, 0, entry >> 2)));
        }
    }
}

pub(crate) fn finish_cells(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [space, list, cell] = ["box", "list", "cell"].map(|name| pass.of(name));
    for i in 0..pass.len(cell) {
        let [x, y, z] = pass.all::<3>(space, i).map(|extent| [low_of(extent), high_of(extent)]);
        let [first, listed] = pass.all(list, i);
        let first = if listed == 0 { NO_LIST } else { first };
        pass.set_all(cell, i, [x[0] | y[0] << 16, z[0] | x[1] << 16, y[1] | z[1] << 16, first]);
    }
}

pub(crate) fn finish_items(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [list, item] = ["list", "item"].map(|name| pass.of(name));
    for i in 0..pass.len(list) {
        let [first, length] = pass.all(list, i);
        if length > 0 {
            let last = first.wrapping_add(length).wrapping_sub(1);
            pass.set(item, 0, last, pass.get(item, 0, last) | LAST_ITEM);
        }
    }
}
