//! Twins of the kernels that merge cells.

use super::map::VoxelMap;
use super::pass::{Pass, Ranks, View, high_of, low_of};
use crate::program::Kernel;
use crate::scene_data::SceneData;
use crate::structures::irregular::merge::{LEAST_MERGED, LONGEST, ROUNDS, STEP_COST};
use crate::tables::texels::Columns;

/// Stands for no leaf.
const NOBODY: u32 = u32::MAX;

pub(crate) fn start_merging(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let (totals, round) = (pass.of("totals"), pass.of("round"));
    let leaves = pass.get(totals, 0, 0);
    pass.set_all(round, 0, [0, 0, leaves, 1, leaves]);
}

pub(crate) fn pair(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let [space, list, round, neighbor, cell_of] =
        ["space", "list", "round", "neighbor", "cell_of"].map(|name| pass.of(name));
    let map = VoxelMap::new(&pass);
    let axis = pass.get(round, 0, 0).min(2) as usize;
    let end = data.build.cells[axis] << data.build.levels;
    for i in 0..pass.len(space) {
        let extent = pass.all::<3>(space, i);
        let partner = |at: u32| {
            let mut voxel = extent.map(low_of);
            voxel[axis] = at;
            let other = pass.get(cell_of, 0, map.find(&pass, voxel));
            let theirs = pass.all::<3>(space, other);
            let is_box = (0..3).all(|a| a == axis || extent[a] == theirs[a]);
            let listed = pass.get(list, 1, i).wrapping_add(pass.get(list, 1, other));
            if is_box && listed as usize <= LONGEST { other } else { NOBODY }
        };
        let (low, high) = (low_of(extent[axis]), high_of(extent[axis]));
        let after = if high < end { partner(high) } else { NOBODY };
        let before = if low > 0 { partner(low - 1) } else { NOBODY };
        pass.set_all(neighbor, i, [after, before]);
    }
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

pub(crate) fn share_lists(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let [owner, item, list, neighbor] = ["owner", "item", "list", "neighbor"].map(|name| pass.of(name));
    let is_known = |pass: &Pass<'_>, i: u32| {
        let before = pass.get(neighbor, 1, pass.get(owner, 0, i));
        let [first, listed] = pass.all(list, before);
        before != NOBODY && is_listed(pass, item, first, listed, pass.get(item, 0, i))
    };
    let known: Vec<u32> = (0..pass.len(owner)).map(|i| is_known(&pass, i).into()).collect();
    Ranks::new(&pass).store(&mut pass, known.into_iter(), 1);
}

pub(crate) fn wish(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let [space, list, neighbor, round, wished] =
        ["space", "list", "neighbor", "round", "wished"].map(|name| pass.of(name));
    let ranks = Ranks::new(&pass);
    let axis = pass.get(round, 0, 0).min(2) as usize;
    let cost = |extent: [u32; 3], listed: u32| {
        let sides = [0, 1, 2].map(|a| u64::from((high_of(extent[a]) - low_of(extent[a])) * data.build.weights[a]));
        let area = sides[0] * sides[1] + sides[1] * sides[2] + sides[2] * sides[0];
        area.wrapping_mul(u64::from(listed) + STEP_COST)
    };
    for i in 0..pass.len(space) {
        let next = pass.get(neighbor, 0, i);
        let mut wish = NOBODY;
        if next != NOBODY {
            let (extent, other) = (pass.all::<3>(space, i), pass.all::<3>(space, next));
            let mut both = extent;
            both[axis] = low_of(extent[axis]) | other[axis] & 0xffff_0000;
            let (listed, [first, theirs]) = (pass.get(list, 1, i), pass.all(list, next));
            let in_all = (listed + theirs).wrapping_sub(ranks.count(&pass, 0, first, theirs));
            if cost(both, in_all) <= cost(extent, listed).wrapping_add(cost(other, theirs)) {
                wish = next;
            }
        }
        pass.set(wished, 0, i, wish);
    }
}

/// Which leaves are merged: `merging.wgsl`.
struct Merging {
    neighbor: View,
    wished: View,
}

impl Merging {
    fn new(pass: &Pass<'_>) -> Self {
        Self { neighbor: pass.of("neighbor"), wished: pass.of("wished") }
    }

    fn is_wished_for(&self, pass: &Pass<'_>, leaf: u32) -> bool {
        let before = pass.get(self.neighbor, 1, leaf);
        before != NOBODY && pass.get(self.wished, 0, before) == leaf
    }

    /// The leaf that is merged into this one.
    fn absorbed_by(&self, pass: &Pass<'_>, leaf: u32) -> Option<u32> {
        let next = pass.get(self.wished, 0, leaf);
        (next != NOBODY && !self.is_wished_for(pass, leaf)).then_some(next)
    }

    /// The leaf into which this one is merged.
    fn absorber_of(&self, pass: &Pass<'_>, leaf: u32) -> Option<u32> {
        let before = pass.get(self.neighbor, 1, leaf);
        (self.is_wished_for(pass, leaf) && self.absorbed_by(pass, before).is_some()).then_some(before)
    }
}

pub(crate) fn unite(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let (list, places) = (pass.of("list"), pass.of("places"));
    let (merging, ranks) = (Merging::new(&pass), Ranks::new(&pass));
    for i in 0..pass.len(list) {
        let is_gone = merging.absorber_of(&pass, i).is_some();
        let mut length = if is_gone { 0 } else { pass.get(list, 1, i) };
        if let Some(next) = merging.absorbed_by(&pass, i).filter(|_| !is_gone) {
            let [first, theirs] = pass.all(list, next);
            length += theirs.wrapping_sub(ranks.count(&pass, 0, first, theirs));
        }
        pass.set_all(places, i, [u32::from(!is_gone), length, 0]);
    }
}

pub(crate) fn gather(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let [space, round, places, totals] = ["space", "round", "places", "totals"].map(|name| pass.of(name));
    let [next_space, next_list] = ["next_space", "next_list"].map(|name| pass.of(name));
    let merging = Merging::new(&pass);
    let axis = pass.get(round, 0, 0).min(2) as usize;
    let count = pass.len(space);
    for i in 0..count {
        if merging.absorber_of(&pass, i).is_some() {
            continue;
        }
        let mut extent = pass.all::<3>(space, i);
        if let Some(next) = merging.absorbed_by(&pass, i) {
            extent[axis] = low_of(extent[axis]) | pass.get(space, axis, next) & 0xffff_0000;
        }
        let [to, first] = pass.all(places, i);
        let end = if i + 1 < count { pass.get(places, 1, i + 1) } else { pass.get(totals, 1, 0) };
        pass.set_all(next_space, to, extent);
        pass.set_all(next_list, to, [first, end.wrapping_sub(first)]);
    }
}

pub(crate) fn deal(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let [owner, item, list, places] = ["owner", "item", "list", "places"].map(|name| pass.of(name));
    let [next_owner, next_item] = ["next_owner", "next_item"].map(|name| pass.of(name));
    let (merging, ranks) = (Merging::new(&pass), Ranks::new(&pass));
    for i in 0..pass.len(owner) {
        let (leaf, triangle) = (pass.get(owner, 0, i), pass.get(item, 0, i));
        let first = pass.get(list, 0, leaf);
        let (mut to, mut place) = (leaf, i.wrapping_sub(first));
        if let Some(before) = merging.absorber_of(&pass, leaf) {
            if ranks.has(&pass, 0, i) {
                continue;
            }
            to = before;
            let [its_first, theirs] = pass.all(list, to);
            let known = ranks.rank(&pass, 0, i).wrapping_sub(ranks.rank(&pass, 0, first));
            place = place.wrapping_add(lower(&pass, item, its_first, theirs, triangle)).wrapping_sub(known);
        } else if let Some(next) = merging.absorbed_by(&pass, leaf) {
            let [its_first, theirs] = pass.all(list, next);
            let lower_there = lower(&pass, item, its_first, theirs, triangle);
            place = place.wrapping_add(lower_there).wrapping_sub(ranks.count(&pass, 0, its_first, lower_there));
        }
        let at = pass.get(places, 1, to).wrapping_add(place);
        let its_leaf = pass.get(places, 0, to);
        pass.set(next_owner, 0, at, its_leaf);
        pass.set(next_item, 0, at, triangle);
    }
}

pub(crate) fn follow(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let (places, cell_of) = (pass.of("places"), pass.of("cell_of"));
    let merging = Merging::new(&pass);
    for i in 0..pass.len(cell_of) {
        let leaf = pass.get(cell_of, 0, i);
        let leaf = merging.absorber_of(&pass, leaf).unwrap_or(leaf);
        pass.set(cell_of, 0, i, pass.get(places, 0, leaf));
    }
}

pub(crate) fn next_axis(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let mut pass = Pass::new(columns, kernel, &data.build);
    let (totals, round) = (pass.of("totals"), pass.of("round"));
    let [axis, rounds, before, _, refined] = pass.all(round, 0);
    if axis + 1 < 3 {
        pass.set(round, 0, 0, axis + 1);
        return;
    }
    let leaves = pass.get(totals, 0, 0);
    let goes_on = rounds + 1 < ROUNDS && before.wrapping_sub(leaves) >= refined.div_ceil(LEAST_MERGED as u32);
    pass.set_all(round, 0, [0, rounds + 1, leaves, goes_on.into()]);
}
