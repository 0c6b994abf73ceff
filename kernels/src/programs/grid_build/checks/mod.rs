//! Twins of the kernels that check what was built: what an unchecked shader would take on trust.

use super::irregular::pass::{Pass, View};
use crate::programs::primitives::scan::SCAN_BLOCK;
use crate::scene_data::SceneData;
use crate::shared::constants::{LAST_ITEM, NO_LIST};
use crate::tables::texels::Columns;

/// Stores the number of wrong elements of each block.
fn count(mut pass: Pass<'_>, over: View, is_wrong: impl Fn(&Pass<'_>, u32) -> bool) {
    let faults = pass.of("faults");
    let elements = pass.len(over);
    for (block, first) in (0..).zip((0..elements).step_by(SCAN_BLOCK)) {
        let end = elements.min(first + SCAN_BLOCK as u32);
        let wrong = (first..end).filter(|&i| is_wrong(&pass, i)).count() as u32;
        pass.set(faults, 0, block, wrong);
    }
}

pub(super) fn check_starts(columns: &mut dyn Columns, data: &SceneData) {
    let pass = Pass::new(columns, &data.build);
    let [start, references] = ["start", "references_in_all"].map(|name| pass.of(name));
    let (cells, all) = (pass.len(start), pass.get(references, 0, 0));
    count(pass, start, |pass, i| {
        let end = if i + 1 < cells { pass.get(start, 0, i + 1) } else { all };
        pass.get(start, 0, i) > end || end > all
    });
}

pub(super) fn check_items(columns: &mut dyn Columns, data: &SceneData) {
    let pass = Pass::new(columns, &data.build);
    let item = pass.of("item");
    count(pass, item, |pass, i| pass.get(item, 0, i) & !LAST_ITEM >= data.build.triangles);
}

pub(super) fn check_cells(columns: &mut dyn Columns, data: &SceneData) {
    let pass = Pass::new(columns, &data.build);
    let [cell, list, item, totals] = ["cell", "list", "item", "totals"].map(|name| pass.of(name));
    count(pass, cell, |pass, i| {
        let [a, b, c, first] = pass.all(cell, i);
        let (low, high) = ([a & 0xffff, a >> 16, b & 0xffff], [b >> 16, c & 0xffff, c >> 16]);
        let end = data.build.cells.map(|n| n << data.build.levels);
        if (0..3).any(|a| low[a] >= high[a] || high[a] > end[a]) {
            return true;
        }
        let (length, references) = (pass.get(list, 1, i), pass.get(totals, 1, 0));
        if first == NO_LIST {
            return length != 0;
        }
        let last = first.wrapping_add(length).wrapping_sub(1);
        first >= references || last < first || last >= references || pass.get(item, 0, last) & LAST_ITEM == 0
    });
}

pub(super) fn check_map(columns: &mut dyn Columns, data: &SceneData) {
    let is_below = columns.parameter() == 1;
    let pass = Pass::new(columns, &data.build);
    let [map, totals, entries] = ["map_entries", "totals", "entries_in_all"].map(|name| pass.of(name));
    count(pass, map, |pass, i| {
        let (entry, top) = (pass.get(map, 0, i), pass.top_cells());
        let (levels, begin) = (entry & 3, entry >> 2);
        if levels == 0 {
            return begin >= pass.get(totals, 0, 0);
        }
        let own = if is_below { i + top } else { i };
        begin <= own || begin + (1 << (3 * levels)) > top + pass.get(entries, 0, 0)
    });
}
