//! Twins of the kernels that divide the cells of the top level.

use super::pass::{Pass, Ranks, low_of};
use crate::numbers::parallel::map_ranges;
use crate::scene_data::SceneData;
use crate::shared::build::Build;
use crate::shared::grid_walk::Grid;
use crate::shared::launch::BLOCK;
use crate::structures::grid::overlap::halves;
use crate::structures::irregular::refine::{CROWDED, GROWTH, GROWTH_OF_ALL, LONG, SHORT, STEP_COST, even_levels};
use crate::tables::texels::Columns;

pub(crate) fn count_top(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let (totals, references) = (pass.of("totals"), pass.of("references_in_all"));
    let listed = pass.get(references, 0, 0);
    pass.set_all(totals, 0, [pass.top_cells(), listed, 0]);
}

pub(crate) fn make_leaves(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [start, totals] = ["start", "totals"].map(|name| pass.of(name));
    let [space, list, division] = ["space", "list", "division"].map(|name| pass.of(name));
    let depth_of_group = pass.of("depth_of_group");
    let Build { cells, levels, .. } = data.build;
    let count = pass.len(start);
    let mut depths = vec![0; (count as usize).div_ceil(BLOCK)];
    for i in 0..count {
        let first = pass.get(start, 0, i);
        let end = if i + 1 < count { pass.get(start, 0, i + 1) } else { pass.get(totals, 1, 0) };
        let length = end.wrapping_sub(first);
        let is_even = data.build.by_content() || u64::from(length) > CROWDED;
        let even = if is_even { even_levels(length.into()) } else { 0 };
        let depth = &mut depths[i as usize / BLOCK];
        *depth = even.max(*depth);
        let cell = [i % cells[0], i / cells[0] % cells[1], i / (cells[0] * cells[1])];
        pass.set_all(space, i, cell.map(|v| v << levels | (v + 1) << levels << 16));
        pass.set_all(list, i, [first, length]);
        pass.set_all(division, i, [length.wrapping_mul(GROWTH as u32).wrapping_add(GROWTH_OF_ALL as u32), even << 8]);
    }
    for (group, depth) in (0..).zip(depths) {
        pass.set(depth_of_group, 0, group, depth);
    }
}

pub(crate) fn start_halving(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [depth_of_group, halving] = ["depth_of_group", "halving"].map(|name| pass.of(name));
    let depth = (0..pass.len(depth_of_group)).map(|group| pass.get(depth_of_group, 0, group)).max();
    pass.set_all(halving, 0, [0, depth.unwrap_or(0)]);
}

pub(crate) fn next_halving(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let halving = pass.of("halving");
    pass.set(halving, 0, 0, pass.get(halving, 0, 0).wrapping_add(1));
}

/// Marks a leaf that stays as it is.
const STAYS: u32 = 1 << 16;

/// Whether a leaf may be divided: `candidate.wgsl`.
fn may_be_divided(build: &Build, levels: u32, length: u32) -> bool {
    let (level, even) = (levels & 0xff, levels >> 8 & 0xff);
    match level < even {
        _ if level >= build.levels || levels & STAYS != 0 => false,
        true => length > 1,
        false => build.by_content() && length as usize > SHORT,
    }
}

/// More than an octree may have.
const MOST_LEVELS: u32 = 32;

/// Whether a leaf is tried with this halving, or was: `candidate.wgsl`.
fn is_its_turn([done, depth]: [u32; 2], levels: u32) -> bool {
    (levels & 0xff) + depth.min(MOST_LEVELS) <= done.wrapping_add(levels >> 8 & 0xff)
}

pub(crate) fn halve(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [owner, item] = ["owner", "item"].map(|name| pass.of(name));
    let [space, list, division] = ["space", "list", "division"].map(|name| pass.of(name));
    let halving = pass.all(pass.of("halving"), 0);
    let inputs: Vec<_> = (0..pass.len(owner))
        .map(|i| {
            let leaf = pass.get(owner, 0, i);
            let levels = pass.get(division, 1, leaf);
            let may_be = is_its_turn(halving, levels) && may_be_divided(&data.build, levels, pass.get(list, 1, leaf));
            may_be.then(|| (levels & 0xff, pass.all::<3>(space, leaf), pass.get(item, 0, i) as usize))
        })
        .collect();
    let mask = |&(level, extent, triangle): &(u32, [u32; 3], usize)| {
        let corners = data.vertices.get(9 * triangle..9 * triangle + 9)?;
        let cell = extent.map(|extent| (low_of(extent) >> (data.build.levels - level)) as i32);
        Some(halves(&grid_of(&data.build, level + 1), f64::from(data.growth), corners, cell))
    };
    let of_range = |range: std::ops::Range<usize>| {
        inputs[range].iter().map(|input| input.as_ref().and_then(mask).unwrap_or(0)).collect::<Vec<_>>()
    };
    let masks = map_ranges(inputs.len(), 1 << 10, of_range);
    Ranks::new(&pass).store(&mut pass, masks.into_iter().flatten(), 8);
}

/// The grid of the cells of a level.
fn grid_of(build: &Build, level: u32) -> Grid {
    let width = build.width.map(|width| width / (1u32 << level) as f32);
    Grid { corner: build.corner, width, ..Grid::default() }
}

pub(crate) fn decide(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [list, division, places] = ["list", "division", "places"].map(|name| pass.of(name));
    let halving = pass.all(pass.of("halving"), 0);
    let ranks = Ranks::new(&pass);
    for i in 0..pass.len(list) {
        let ([first, length], [budget, levels]) = (pass.all(list, i), pass.all(division, i));
        let (mut is_divided, mut after, mut left) = (false, 0, 0);
        if !is_its_turn(halving, levels) {
            left = u32::from(may_be_divided(&data.build, levels, length));
        } else if may_be_divided(&data.build, levels, length) {
            for half in 0..8 {
                let listed = ranks.count(&pass, half, first, length);
                after += listed;
                left += u32::from(may_be_divided(&data.build, levels + 1, listed));
            }
            let is_gain = after + (STEP_COST as u32) < 4 * length && after <= budget;
            is_divided = is_gain || levels & 0xff < levels >> 8 && length as usize <= LONG;
            left = if is_divided { left } else { 0 };
        }
        let values = if is_divided { [8, after, left] } else { [1, length, left] };
        pass.set_all(places, i, values);
    }
}

pub(crate) fn divide(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [space, list, division] = ["space", "list", "division"].map(|name| pass.of(name));
    let [places, sums, totals] = ["places", "places_of_block", "totals"].map(|name| pass.of(name));
    let [next_space, next_list, next_division] = ["next_space", "next_list", "next_division"].map(|name| pass.of(name));
    let halving = pass.all(pass.of("halving"), 0);
    let ranks = Ranks::new(&pass);
    let count = pass.len(list);
    for i in 0..count {
        let [to, mut reference] = [0, 1].map(|layer| pass.sum_before(places, sums, layer, i));
        let end = if i + 1 < count { pass.sum_before(places, sums, 0, i + 1) } else { pass.get(totals, 0, 0) };
        let (extent, [first, length], [budget, levels]) =
            (pass.all::<3>(space, i), pass.all(list, i), pass.all(division, i));
        if end.wrapping_sub(to) != 8 {
            pass.set_all(next_space, to, extent);
            pass.set_all(next_list, to, [reference, length]);
            let stays = if is_its_turn(halving, levels) { STAYS } else { 0 };
            pass.set_all(next_division, to, [budget, levels | stays]);
            continue;
        }
        let listed: [u32; 8] = std::array::from_fn(|half| ranks.count(&pass, half, first, length));
        let after: u32 = listed.iter().sum();
        let width = (1 << data.build.levels) >> ((levels & 0xff) + 1);
        for (half, listed) in (0..).zip(listed) {
            let low = [0, 1, 2].map(|a| low_of(extent[a]) + width * (half >> a & 1));
            let share = u64::from(budget) * u64::from(listed) / u64::from(after.max(1));
            pass.set_all(next_space, to + half, low.map(|low| low | (low + width) << 16));
            pass.set_all(next_list, to + half, [reference, listed]);
            pass.set_all(next_division, to + half, [share as u32, levels + 1]);
            reference += listed;
        }
    }
}

pub(crate) fn hand_down(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    let [owner, item, list] = ["owner", "item", "list"].map(|name| pass.of(name));
    let [places, sums] = ["places", "places_of_block"].map(|name| pass.of(name));
    let [division, next_division, next_list] = ["division", "next_division", "next_list"].map(|name| pass.of(name));
    let [next_owner, next_item] = ["next_owner", "next_item"].map(|name| pass.of(name));
    let ranks = Ranks::new(&pass);
    for i in 0..pass.len(owner) {
        let (leaf, triangle) = (pass.get(owner, 0, i), pass.get(item, 0, i));
        let (first, to) = (pass.get(list, 0, leaf), pass.sum_before(places, sums, 0, leaf));
        if (pass.get(next_division, 1, to) ^ pass.get(division, 1, leaf)) & 0xff == 0 {
            let place = pass.get(next_list, 0, to).wrapping_add(i).wrapping_sub(first);
            pass.set(next_owner, 0, place, to);
            pass.set(next_item, 0, place, triangle);
            continue;
        }
        for half in 0..8 {
            if !ranks.has(&pass, half, i) {
                continue;
            }
            let before = ranks.rank(&pass, half, i).wrapping_sub(ranks.rank(&pass, half, first));
            let its_leaf = to + half as u32;
            let place = pass.get(next_list, 0, its_leaf).wrapping_add(before);
            pass.set(next_owner, 0, place, its_leaf);
            pass.set(next_item, 0, place, triangle);
        }
    }
}

pub(crate) fn adopt(columns: &mut dyn Columns, data: &SceneData) {
    let mut pass = Pass::new(columns, &data.build);
    for (from, to) in [("first_in", "first_out"), ("second_in", "second_out")] {
        let (from, to) = (pass.of(from), pass.of(to));
        for i in 0..pass.len(from) {
            pass.set(to, 0, i, pass.get(from, 0, i));
        }
    }
}
