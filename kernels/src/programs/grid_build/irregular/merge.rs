//! Twins of the kernels that merge cells.

use super::map::VoxelMap;
use super::pass::{Pass, View, high_of, low_of};
use crate::scene_data::SceneData;
use crate::structures::irregular::merge::{LEAST_MERGED, LONGEST, ROUNDS, STEP_COST, union};
use crate::tables::texels::Columns;

/// Stands for no leaf.
const NOBODY: u32 = u32::MAX;

pub(crate) fn start_merging(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let (totals, round) = (pass.of("totals"), pass.of("round"));
    let leaves = pass.get(totals, 0, 0);
    pass.set_all(round, 0, [0, 0, leaves, 1, leaves]);
}

/// Number of these references, one after the other, that are of lower triangles.
fn lower(pass: &Pass<'_>, item: View, first: u32, references: u32, triangle: u32) -> u32 {
    let (mut low, mut high) = (0, references);
    while low < high {
        let middle = low + (high - low) / 2;
        if pass.get(item, 0, first.wrapping_add(middle)) < triangle { low = middle + 1 } else { high = middle }
    }
    low
}

pub(super) fn is_listed(pass: &Pass<'_>, item: View, first: u32, references: u32, triangle: u32) -> bool {
    let place = lower(pass, item, first, references, triangle);
    place < references && pass.get(item, 0, first.wrapping_add(place)) == triangle
}

/// The triangles of a list, at most so many: somebody may have edited its length.
fn listed(pass: &Pass<'_>, item: View, [first, length]: [u32; 2], most: u32) -> Vec<u32> {
    (0..length.min(most)).map(|k| pass.get(item, 0, first.wrapping_add(k))).collect()
}

pub(crate) fn wish(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [space, list, item, cell_of, round] = ["space", "list", "item", "cell_of", "round"].map(|name| pass.of(name));
    let [wished, wished_by] = ["wished", "wished_by"].map(|name| pass.of(name));
    let map = VoxelMap::new(&pass);
    let axis = pass.get(round, 0, 0).min(2) as usize;
    let end = data.build.cells[axis] << data.build.levels;
    let cost = |extent: [u32; 3], listed: u32| {
        let sides = [0, 1, 2].map(|a| u64::from((high_of(extent[a]) - low_of(extent[a])) * data.build.weights[a]));
        let area = sides[0] * sides[1] + sides[1] * sides[2] + sides[2] * sides[0];
        area.wrapping_mul(u64::from(listed) + STEP_COST)
    };
    for i in 0..pass.len(space) {
        let extent = pass.all::<3>(space, i);
        if high_of(extent[axis]) >= end {
            continue;
        }
        let mut voxel = extent.map(low_of);
        voxel[axis] = high_of(extent[axis]);
        let next = pass.get(cell_of, 0, map.find(&pass, voxel));
        let other = pass.all::<3>(space, next);
        let is_box = (0..3).all(|a| a == axis || extent[a] == other[a]);
        let (own, theirs): ([u32; 2], [u32; 2]) = (pass.all(list, i), pass.all(list, next));
        if !is_box || u64::from(own[1]) + u64::from(theirs[1]) > LONGEST as u64 {
            continue;
        }
        let mut both = extent;
        both[axis] = low_of(extent[axis]) | other[axis] & 0xffff_0000;
        let apart = cost(extent, own[1]).wrapping_add(cost(other, theirs[1]));
        if cost(both, own[1].max(theirs[1])) > apart {
            continue;
        }
        let [a, b] = [own, theirs].map(|list| listed(&pass, item, list, u32::MAX));
        let in_both = (a.len() + b.len() - union(&a, &b).len()) as u32;
        if cost(both, (own[1] + theirs[1]).wrapping_sub(in_both)) <= apart {
            pass.set_all(wished, i, [next, in_both]);
            pass.set(wished_by, 0, next, i);
        }
    }
}

/// Which leaves are merged: `merging.wgsl`.
struct Merging {
    wished: View,
    wished_by: View,
}

impl Merging {
    fn new(pass: &Pass<'_>) -> Self {
        Self { wished: pass.of("wished"), wished_by: pass.of("wished_by") }
    }

    /// The leaf that is merged into this one.
    fn absorbed_by(&self, pass: &Pass<'_>, leaf: u32) -> Option<u32> {
        let next = pass.get(self.wished, 0, leaf);
        (next != NOBODY && pass.get(self.wished_by, 0, leaf) == NOBODY).then_some(next)
    }

    /// The leaf into which this one is merged.
    fn absorber_of(&self, pass: &Pass<'_>, leaf: u32) -> Option<u32> {
        let before = pass.get(self.wished_by, 0, leaf);
        (before != NOBODY && pass.get(self.wished_by, 0, before) == NOBODY).then_some(before)
    }
}

pub(crate) fn unite(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let (list, kept) = (pass.of("list"), pass.of("kept"));
    let merging = Merging::new(&pass);
    for i in 0..pass.len(list) {
        let is_gone = merging.absorber_of(&pass, i).is_some();
        let mut length = if is_gone { 0 } else { pass.get(list, 1, i) };
        if let Some(next) = merging.absorbed_by(&pass, i).filter(|_| !is_gone) {
            length = length.wrapping_add(pass.get(list, 1, next)).wrapping_sub(pass.get(merging.wished, 1, i));
        }
        pass.set_all(kept, i, [u32::from(!is_gone), length]);
    }
}

pub(crate) fn gather(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [space, list, item, round] = ["space", "list", "item", "round"].map(|name| pass.of(name));
    let [kept, sums, totals] = ["kept", "kept_of_block", "totals"].map(|name| pass.of(name));
    let [next_space, next_list, next_item] = ["next_space", "next_list", "next_item"].map(|name| pass.of(name));
    let merging = Merging::new(&pass);
    let axis = pass.get(round, 0, 0).min(2) as usize;
    let most = pass.get(totals, 1, 0);
    for i in 0..pass.len(space) {
        if merging.absorber_of(&pass, i).is_some() {
            continue;
        }
        let mut extent = pass.all::<3>(space, i);
        let [to, first] = [0, 1].map(|layer| pass.sum_before(kept, sums, layer, i));
        let mut items = listed(&pass, item, pass.all(list, i), most);
        let mut length = pass.get(list, 1, i);
        if let Some(next) = merging.absorbed_by(&pass, i) {
            extent[axis] = low_of(extent[axis]) | pass.get(space, axis, next) & 0xffff_0000;
            let others = listed(&pass, item, pass.all(list, next), most);
            length = length.wrapping_add(pass.get(list, 1, next)).wrapping_sub(pass.get(merging.wished, 1, i));
            items = union(&items, &others);
        }
        pass.set_all(next_space, to, extent);
        pass.set_all(next_list, to, [first, length]);
        for (place, triangle) in (first..).zip(items) {
            pass.set(next_item, 0, place, triangle);
        }
    }
}

pub(crate) fn follow(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [kept, sums, cell_of] = ["kept", "kept_of_block", "cell_of"].map(|name| pass.of(name));
    let merging = Merging::new(&pass);
    for i in 0..pass.len(cell_of) {
        let leaf = pass.get(cell_of, 0, i);
        let leaf = merging.absorber_of(&pass, leaf).unwrap_or(leaf);
        pass.set(cell_of, 0, i, pass.sum_before(kept, sums, 0, leaf));
    }
}

pub(crate) fn next_axis(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let (totals, round) = (pass.of("totals"), pass.of("round"));
    let [axis, rounds, before, _, refined] = pass.all(round, 0);
    let axis = axis.wrapping_add(1);
    let (axis, rounds_after) = if axis >= 3 { (0, rounds.wrapping_add(1)) } else { (axis, rounds) };
    let leaves = pass.get(totals, 0, 0);
    let is_worth_it = rounds == 0 || before.wrapping_sub(leaves) >= refined.div_ceil(LEAST_MERGED as u32);
    pass.set_all(round, 0, [axis, rounds_after, leaves, u32::from(rounds_after < ROUNDS && is_worth_it)]);
}
