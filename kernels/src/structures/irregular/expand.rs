//! Expands the box of each cell over neighbours whose triangles it lists too.

use super::map::Map;
use super::{Draft, Span};
use crate::numbers::parallel::map_ranges;

/// Most times that a cell's box is expanded on each side, by a layer of neighbours each.
pub(crate) const ROUNDS: u32 = 16;

/// Most neighbours and triangles of their lists that are looked at, for each cell. A face with more is not moved.
pub(crate) const MOST_LOOKED_AT: u32 = 1024;

/// The expanded boxes. Each follows from the cells alone, not from those of others.
pub(super) fn expand(draft: &Draft, map: &Map) -> Vec<Span> {
    let parts =
        map_ranges(draft.spans.len(), 1 << 8, |range| range.map(|cell| expanded(cell, draft, map)).collect::<Vec<_>>());
    parts.into_iter().flatten().collect()
}

fn expanded(cell: usize, draft: &Draft, map: &Map) -> Span {
    let (mut span, mut seen) = (draft.spans[cell], 0);
    // A face that a neighbour stops stays there: the box only grows, so it keeps this neighbour.
    let mut stopped = [[false; 2]; 3];
    for _ in 0..ROUNDS {
        let before = span;
        for (axis, [down, up]) in stopped.iter_mut().enumerate() {
            if !*up && span.high[axis] < map.grid.cells[axis] {
                let by = layer(cell, &span, (axis, true), &mut seen, draft, map);
                span.high[axis] += by;
                *up = by == 0;
            }
            if !*down && span.low[axis] > 0 {
                let by = layer(cell, &span, (axis, false), &mut seen, draft, map);
                span.low[axis] -= by;
                *down = by == 0;
            }
        }
        if span == before || seen > MOST_LOOKED_AT {
            break;
        }
    }
    span
}

/// By how much a face can be moved: to where the first of the neighbours behind it ends; 0 if one of them lists a
/// triangle that the cell does not list.
fn layer(cell: usize, span: &Span, (axis, is_up): (usize, bool), seen: &mut u32, draft: &Draft, map: &Map) -> i32 {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let mut at = span.low;
    at[axis] = if is_up { span.high[axis] } else { span.low[axis] - 1 };
    let mut depth = i32::MAX;
    while at[v] < span.high[v] {
        let mut next_row = span.high[v];
        at[u] = span.low[u];
        while at[u] < span.high[u] {
            let neighbour = map.find(at) as usize;
            let (theirs, own) = (&draft.lists[neighbour], &draft.lists[cell]);
            *seen += 1 + if theirs.len() <= own.len() { theirs.len() as u32 } else { 0 };
            if *seen > MOST_LOOKED_AT || !is_subset(theirs, own) {
                return 0;
            }
            let there = &draft.spans[neighbour];
            depth = depth.min(if is_up { there.high[axis] - at[axis] } else { at[axis] + 1 - there.low[axis] });
            next_row = next_row.min(there.high[v]);
            at[u] = there.high[u];
        }
        at[v] = next_row;
    }
    depth
}

fn is_subset(small: &[u32], large: &[u32]) -> bool {
    let mut large = large.iter();
    small.len() <= large.len() && small.iter().all(|item| large.by_ref().find(|&&other| other >= *item) == Some(item))
}
