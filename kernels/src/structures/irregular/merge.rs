//! Merges neighbours that form a box, where the surface area heuristic says so.

use super::layout::Layout;
use super::map::Map;
use super::{Draft, Span};
use crate::numbers::parallel::map_ranges;

/// Cost of a step from cell to cell, in triangle tests.
pub(crate) const STEP_COST: u64 = 1;

/// Most rounds; each merges pairs along x, y and z.
pub(crate) const ROUNDS: u32 = 8;

/// After the first round, merging ends with an axis along which fewer than 1 / `LEAST_MERGED` of the original cells are
/// merged. Further ones would save memory, but hardly any steps per ray.
pub(crate) const LEAST_MERGED: usize = 64;

/// Longest list that costs count; longer ones are never merged.
pub(crate) const LONGEST: usize = 1 << 14;

/// Merges until hardly any pair is left, and numbers the remaining cells anew.
pub(super) fn merge(mut draft: Draft, map: &mut Map, layout: &Layout) -> Draft {
    let mut current: Vec<u32> = (0..draft.spans.len() as u32).collect();
    for (round, axis) in (0..ROUNDS).flat_map(|round| (0..3).map(move |axis| (round, axis))) {
        let merged = merge_along(axis, &mut draft, &mut current, map, layout);
        if round > 0 && merged * LEAST_MERGED < draft.spans.len() {
            break;
        }
    }
    let mut number = vec![u32::MAX; draft.spans.len()];
    let mut kept = Draft { spans: Vec::new(), lists: Vec::new() };
    for (i, (span, list)) in draft.spans.into_iter().zip(draft.lists).enumerate() {
        if current[i] == i as u32 {
            number[i] = kept.spans.len() as u32;
            kept.spans.push(span);
            kept.lists.push(list);
        }
    }
    map.rename(|cell| number[current[cell as usize] as usize]);
    kept
}

/// Stands for no cell.
const NOBODY: u32 = u32::MAX;

/// Merges pairs along an axis; every cell takes part in one at most. Which pairs follows from the cells before the
/// round alone: the first two of a row of cells that could each be merged with the next one.
fn merge_along(axis: usize, draft: &mut Draft, current: &mut [u32], map: &Map, layout: &Layout) -> usize {
    let partners: Vec<u32> = {
        let (draft, current) = (&*draft, &*current);
        let partner = |cell: u32| {
            let span = &draft.spans[cell as usize];
            let mut beyond = span.low;
            beyond[axis] = span.high[axis];
            let is_alive = current[cell as usize] == cell && beyond[axis] < map.grid.cells[axis];
            let next = is_alive.then(|| current[map.find(beyond) as usize])?;
            is_better(axis, cell, next, draft, layout).then_some(next)
        };
        let of_range = |range: std::ops::Range<usize>| {
            range.map(|cell| partner(cell as u32).unwrap_or(NOBODY)).collect::<Vec<_>>()
        };
        map_ranges(draft.spans.len(), 1 << 10, of_range).concat()
    };
    let mut is_next = vec![false; partners.len()];
    partners.iter().filter(|&&next| next != NOBODY).for_each(|&next| is_next[next as usize] = true);
    let firsts = partners.iter().enumerate().filter(|&(cell, &next)| next != NOBODY && !is_next[cell]);
    let pairs: Vec<(u32, u32)> = firsts.map(|(cell, &next)| (cell as u32, next)).collect();
    for &(cell, next) in &pairs {
        let other = std::mem::take(&mut draft.lists[next as usize]);
        let list = &mut draft.lists[cell as usize];
        *list = union(list, &other);
        draft.spans[cell as usize].high[axis] = draft.spans[next as usize].high[axis];
        current[next as usize] = cell;
    }
    // Chains of cells that were merged into others end at once.
    for cell in 0..current.len() {
        let mut root = current[cell];
        while current[root as usize] != root {
            root = current[root as usize];
        }
        current[cell] = root;
    }
    pairs.len()
}

/// Whether two neighbours form a box, and cost no more as one cell.
fn is_better(axis: usize, a: u32, b: u32, draft: &Draft, layout: &Layout) -> bool {
    let [(first, list), (second, other)] = [a, b].map(|i| (&draft.spans[i as usize], &draft.lists[i as usize]));
    let is_box =
        (0..3).filter(|&c| c != axis).all(|c| first.low[c] == second.low[c] && first.high[c] == second.high[c]);
    if !is_box || list.len() + other.len() > LONGEST {
        return false;
    }
    let mut both = Span { ..*first };
    both.high[axis] = second.high[axis];
    let cost = |span: &Span, length: usize| layout.half_area(span) * (length as u64 + STEP_COST);
    cost(&both, union_length(list, other)) <= cost(first, list.len()) + cost(second, other.len())
}

fn union_length(a: &[u32], b: &[u32]) -> usize {
    let (mut i, mut k, mut length) = (0, 0, 0);
    while i < a.len() && k < b.len() {
        let (x, y) = (a[i], b[k]);
        i += usize::from(x <= y);
        k += usize::from(y <= x);
        length += 1;
    }
    length + (a.len() - i) + (b.len() - k)
}

/// The triangles of two ascending lists, each once, in ascending order.
pub(crate) fn union(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut all = [a, b].concat();
    all.sort_unstable();
    all.dedup();
    all
}
