//! Counts and fills the lists of a grid, on all cores.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use super::GridData;
use super::overlap::Overlap;
use crate::numbers::parallel::{for_chunks, for_ranges};
use crate::shared::grid_walk::Grid;

/// Triangles whose references are collected before they are counted or listed, and the limit of references: few enough
/// that the cells they touch stay in a core's cache.
const BATCH: usize = 256;
const BATCH_REFERENCES: usize = 1 << 14;

/// Number of triangles that each cell will list, or `None` if they are more than `limit` in total.
pub(super) fn count(vertices: &[f32], grid: &Grid, growth: f32, limit: u64) -> Option<Vec<AtomicU32>> {
    let cells = grid.cells.iter().map(|&n| n as usize).product::<usize>();
    let counts: Vec<AtomicU32> = std::iter::repeat_with(|| AtomicU32::new(0)).take(cells + 1).collect();
    let references = AtomicU64::new(0);
    for_references(vertices, grid, growth, &counts, |batch| {
        for &(_, cell) in batch {
            counts[cell as usize].fetch_add(1, Ordering::Relaxed);
        }
        references.fetch_add(batch.len() as u64, Ordering::Relaxed) + (batch.len() as u64) <= limit
    });
    (references.into_inner() <= limit).then_some(counts)
}

/// Calls `f` with every triangle and each cell that lists it, a batch at a time, until it returns false.
fn for_references(
    vertices: &[f32],
    grid: &Grid,
    growth: f32,
    counts: &[AtomicU32],
    f: impl Fn(&[(u32, u32)]) -> bool + Sync,
) {
    let goes_on = AtomicBool::new(true);
    let flush = |batch: &mut Vec<(u32, u32)>| {
        // An atomic addition waits for its cell to be loaded from memory; prior loads overlap.
        let touched = batch.iter().fold(0, |sum, &(_, cell)| sum ^ counts[cell as usize].load(Ordering::Relaxed));
        std::hint::black_box(touched);
        if goes_on.load(Ordering::Relaxed) && !f(batch) {
            goes_on.store(false, Ordering::Relaxed);
        }
        batch.clear();
    };
    for_ranges(vertices.len() / 9, 16 * BATCH, |range| {
        let mut batch = Vec::with_capacity(BATCH_REFERENCES);
        for triangle in range.clone() {
            if !goes_on.load(Ordering::Relaxed) {
                return;
            }
            let overlap = Overlap::new(grid, f64::from(growth), &vertices[9 * triangle..9 * triangle + 9]);
            overlap.for_cells(|cell| {
                batch.push((triangle as u32, grid.cell_index(cell)));
                if batch.len() == BATCH_REFERENCES {
                    flush(&mut batch);
                }
            });
            if (triangle - range.start) % BATCH == BATCH - 1 {
                flush(&mut batch);
            }
        }
        flush(&mut batch);
    });
}

/// Turns counts into starts, in place, and fills the lists.
pub(super) fn fill(vertices: &[f32], grid: Grid, growth: f32, counts: Vec<AtomicU32>) -> GridData {
    let mut references = 0;
    for count in &counts {
        references += count.swap(references, Ordering::Relaxed);
    }
    // Each list is filled in any order; its start moves to its end, which is the next list's start.
    let slots: Vec<AtomicU32> = std::iter::repeat_with(|| AtomicU32::new(0)).take(references as usize).collect();
    for_references(vertices, &grid, growth, &counts, |batch| {
        for &(triangle, cell) in batch {
            let slot = counts[cell as usize].fetch_add(1, Ordering::Relaxed);
            slots[slot as usize].store(triangle, Ordering::Relaxed);
        }
        true
    });
    let mut cells: Vec<u32> = counts.into_iter().map(AtomicU32::into_inner).collect();
    let mut items: Vec<u32> = slots.into_iter().map(AtomicU32::into_inner).collect();
    let last = cells.len() - 1;
    cells.copy_within(0..last, 1);
    cells[0] = 0;
    sort_lists(&cells, &mut items);
    GridData { grid, cells, items, growth }
}

/// Sorts every list, so that the order of filling does not matter.
fn sort_lists(cells: &[u32], items: &mut [u32]) {
    let mut lists = Vec::new();
    let mut rest = items;
    const LISTS: usize = 1 << 14;
    for first in (0..cells.len() - 1).step_by(LISTS) {
        let last = (first + LISTS).min(cells.len() - 1);
        let (piece, tail) = rest.split_at_mut((cells[last] - cells[first]) as usize);
        lists.push((first..last, piece));
        rest = tail;
    }
    for_chunks(&mut lists, 1, |_, piece| {
        for (range, items) in piece {
            let base = cells[range.start];
            for cell in range.clone() {
                items[(cells[cell] - base) as usize..(cells[cell + 1] - base) as usize].sort_unstable();
            }
        }
    });
}
