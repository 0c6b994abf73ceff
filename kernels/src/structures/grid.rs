//! The uniform grid: its planes, its resolution, and which triangles each cell lists.
//!
//! ```text
//! grid_cells  u32  one a cell, x fastest, and one more: where the cell's list starts in grid_items
//! grid_items  u32  triangle ids, ascending within a cell; cell c owns cells[c] .. cells[c + 1]
//! ```
//!
//! **Planes are exact.** Corner and cell width are multiples of one quantum, a power of two chosen so
//! that every plane has at most 24 bits in it: `corner + width * i` is never rounded, contracted or not.
//!
//! **Lists are conservative.** A ray's computed place differs from its true one by at most [`growth`],
//! 40 roundings of 2⁻²⁴ of the largest distance involved: 7 in a crossing's t (difference 1, reciprocal 5,
//! product 1), 5 in the entry point and its cell, and for the triangle 10 across the ray (its sheared
//! corners) and 18 along it (its t), as `raystep_lab::reference` has them. Every cell is grown by that much
//! before the exact triangle/box test, so the cell in which a ray is believed to be lists what the ray can
//! meet there. Needles and triangles seen edge-on, whose t moves by more than 18 roundings when their edge
//! functions round, are beyond this bound: there the grid may pick the other of two triangles that f32
//! cannot tell apart, a tie.

mod distance;
pub(crate) mod overlap;
mod resolution;
mod stats;

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use crate::numbers::parallel::{for_chunks, for_ranges, map_ranges};
use crate::numbers::units::{exp2, floor_log2};
pub use crate::options::GridSize;
use crate::shared::grid_walk::Grid;
pub use distance::distances;
use overlap::Overlap;
pub use resolution::{CELLS_PER_TRIANGLE, LEAPING_CELLS_PER_TRIANGLE, automatic_cells};
use resolution::{cubes, leaping};
pub use stats::GridStats;

/// The grid cannot be built.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GridError {
    /// A cell count of 0, or more cells than an index can name.
    #[error("a grid of {} x {} x {} cells cannot be built: each count must be 1 to 4096 and their product at most {MAX_CELLS}", .0[0], .0[1], .0[2])]
    Size([u32; 3]),
    /// The lists are longer than the executor can hold.
    #[error(
        "the lists of a grid of {} x {} x {} cells would have more than {limit} entries, the most that fit one buffer here: use fewer cells",
        cells[0], cells[1], cells[2]
    )]
    TooManyReferences {
        /// Cells along x, y and z.
        cells: [u32; 3],
        /// Most entries.
        limit: u64,
    },
}

/// Most cells in all.
pub const MAX_CELLS: u64 = 1 << 28;

/// A built grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridData {
    /// The uniform.
    pub grid: Grid,
    /// Starts of the lists, one a cell and one more.
    pub cells: Vec<u32>,
    /// The lists.
    pub items: Vec<u32>,
    /// What each cell was grown by, traced units.
    pub growth: f32,
}

/// What a cell is grown by, in traced units, where no origin, corner or distance between the two
/// exceeds `reach`.
#[must_use]
pub fn growth(reach: f32) -> f32 {
    40.0 * reach.max(f32::MIN_POSITIVE * 1e9) / (1 << 24) as f32
}

/// A grid whose lists are counted, but not filled: enough to tell whether it is worth filling.
#[derive(Debug)]
pub struct CountedGrid {
    grid: Grid,
    growth: f32,
    /// Entries of each cell's list, and one more that is 0.
    counts: Vec<AtomicU32>,
}

impl CountedGrid {
    /// Whether most cells are empty: where a walk seldom finds a cell to leap over, looking for one costs more.
    #[must_use]
    pub fn is_sparse(&self) -> bool {
        let cells = self.counts.len();
        let empty = self.counts[..cells - 1].iter().filter(|count| count.load(Ordering::Relaxed) == 0).count();
        cells > 64 && 2 * empty > cells
    }

    /// Lists the triangles of each cell. `vertices` are those that were counted.
    #[must_use]
    pub fn fill(self, vertices: &[f32]) -> GridData {
        fill(vertices, self.grid, self.growth, self.counts)
    }
}

/// Counts the lists of the grid over `vertices` (nine floats a triangle, traced units).
///
/// `reach` bounds every coordinate of corners and ray origins and the distances between them; `most_words`
/// is what one buffer of the executor holds. Without `is_grown`, cells list only the triangles that they exactly meet:
/// what [`growth`] is for, left out.
///
/// # Errors
/// Where the size asked for, or the lists, cannot be indexed.
pub fn count_lists(
    vertices: &[f32],
    size: GridSize,
    reach: f32,
    is_grown: bool,
    most_words: u64,
) -> Result<CountedGrid, GridError> {
    let growth = Growth { planes: growth(reach), lists: if is_grown { growth(reach) } else { 0.0 } };
    let most = most_words.min(u64::from(u32::MAX));
    let triangles = (vertices.len() / 9) as u64;
    let GridSize::Cells(cells) = size else {
        return automatic(vertices, |extent| automatic_cells(triangles, extent), 16, growth, most);
    };
    let (grid, growth) = planes(vertices, GridSize::Cells(cells), reach, is_grown, most_words)?;
    counted(grid, growth, vertices, most)
}

/// Where the planes of that grid are, and what its cells are grown by, without its lists; an automatic resolution is
/// chosen by counting them.
///
/// # Errors
/// Where the size asked for, or the lists of an automatic one, cannot be indexed.
pub fn planes(
    vertices: &[f32],
    size: GridSize,
    reach: f32,
    is_grown: bool,
    most_words: u64,
) -> Result<(Grid, f32), GridError> {
    let GridSize::Cells(cells) = size else {
        let counted = count_lists(vertices, size, reach, is_grown, most_words)?;
        return Ok((counted.grid, counted.growth));
    };
    let (min, max) = bounds(vertices);
    check_cells(cells)?;
    Ok((layout(min, max, cells, growth(reach)), if is_grown { growth(reach) } else { 0.0 }))
}

/// The same for a grid whose automatic resolution suits walks that leap over empty cells.
///
/// # Errors
/// Where the lists cannot be indexed.
pub fn count_lists_for_leaps(vertices: &[f32], reach: f32, most_words: u64) -> Result<CountedGrid, GridError> {
    let wanted = leaping((vertices.len() / 9) as u64);
    let growth = Growth { planes: growth(reach), lists: growth(reach) };
    automatic(vertices, |extent| cubes(wanted, extent), 64, growth, most_words.min(u64::from(u32::MAX)))
}

/// Builds the grid over `vertices`, see [`count_lists`].
///
/// # Errors
/// Where the size asked for, or the lists, cannot be indexed.
pub fn build(vertices: &[f32], size: GridSize, reach: f32, most_words: u64) -> Result<GridData, GridError> {
    Ok(count_lists(vertices, size, reach, true, most_words)?.fill(vertices))
}

/// Builds the grid for leaps over `vertices`, see [`count_lists_for_leaps`].
///
/// # Errors
/// Where the lists cannot be indexed.
pub fn build_for_leaps(vertices: &[f32], reach: f32, most_words: u64) -> Result<GridData, GridError> {
    Ok(count_lists_for_leaps(vertices, reach, most_words)?.fill(vertices))
}

/// Counts and lists the triangles of each cell of a grid whose planes are there already, and what its cells are grown by.
///
/// # Errors
/// Where the lists cannot be indexed.
pub fn lists(grid: &Grid, growth: f32, vertices: &[f32], most_words: u64) -> Result<GridData, GridError> {
    Ok(counted(*grid, growth, vertices, most_words.min(u64::from(u32::MAX)))?.fill(vertices))
}

/// Counts the lists of a grid, of which there may be so many entries.
fn counted(grid: Grid, growth: f32, vertices: &[f32], limit: u64) -> Result<CountedGrid, GridError> {
    let too_many = || GridError::TooManyReferences { cells: grid.cells.map(|n| n as u32), limit };
    let counts = count(vertices, &grid, growth, limit).ok_or_else(too_many)?;
    Ok(CountedGrid { grid, growth, counts })
}

/// What planes stand off the scene by half of, and what cells are grown by for their lists.
#[derive(Clone, Copy)]
struct Growth {
    planes: f32,
    lists: f32,
}

/// The resolution that `cells` wants for the scene's extent, or a coarser one whose lists have at most so many
/// entries a triangle, and `most` in all.
fn automatic(
    vertices: &[f32],
    cells: impl Fn([f64; 3]) -> [u32; 3],
    entries: u64,
    growth: Growth,
    most: u64,
) -> Result<CountedGrid, GridError> {
    let (min, max) = bounds(vertices);
    let triangles = (vertices.len() / 9) as u64;
    let extent = [0, 1, 2].map(|a| f64::from(max[a]) - f64::from(min[a]));
    // Cells not much larger than their growth would list their neighbours' triangles as well.
    let finest = extent.map(|e| (e / (8.0 * f64::from(growth.planes))).clamp(1.0, 4096.0) as u32);
    let mut cells = cells(extent);
    cells.iter_mut().zip(finest).for_each(|(n, finest)| *n = (*n).min(finest));
    let coarser = |cells: [u32; 3]| cells.map(|n| (n * 2 / 3).max(1));
    while cell_count(cells) >= most && cells != [1; 3] {
        cells = coarser(cells);
    }
    loop {
        let grid = layout(min, max, cells, growth.planes);
        // Triangles much larger than a cell would fill every list; a coarser grid is cheaper then.
        if let Some(counts) = count(vertices, &grid, growth.lists, most.min(entries * triangles + 4096)) {
            return Ok(CountedGrid { grid, growth: growth.lists, counts });
        }
        if cells == [1; 3] {
            return Err(GridError::TooManyReferences { cells, limit: most });
        }
        cells = coarser(cells);
    }
}

fn cell_count(cells: [u32; 3]) -> u64 {
    cells.iter().map(|&n| u64::from(n)).product()
}

/// How many cells a grid of that size has.
///
/// # Errors
/// Where it cannot be built.
pub fn check_cells(cells: [u32; 3]) -> Result<u64, GridError> {
    let count = cell_count(cells);
    if cells.iter().any(|&n| n == 0 || n > 4096) || count > MAX_CELLS {
        return Err(GridError::Size(cells));
    }
    Ok(count)
}

/// Lower and upper corner; the unit box without triangles.
fn bounds(vertices: &[f32]) -> ([f32; 3], [f32; 3]) {
    const CHUNK: usize = 9 << 14;
    let parts = map_ranges(vertices.len(), CHUNK, |range| {
        vertices[range].chunks_exact(3).fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), p| {
            ([0, 1, 2].map(|a| low[a].min(p[a])), [0, 1, 2].map(|a| high[a].max(p[a])))
        })
    });
    parts
        .into_iter()
        .reduce(|a, b| ([0, 1, 2].map(|i| a.0[i].min(b.0[i])), [0, 1, 2].map(|i| a.1[i].max(b.1[i]))))
        .unwrap_or(([0.0; 3], [1.0; 3]))
}

/// Places the planes: the box of the scene with a margin of twice the growth, on exact planes.
fn layout(min: [f32; 3], max: [f32; 3], cells: [u32; 3], growth: f32) -> Grid {
    let mut grid = Grid { cells: cells.map(|n| n as i32), ..Grid::default() };
    for a in 0..3 {
        let margin = 2.0 * f64::from(growth);
        let (low, high) = (f64::from(min[a]) - margin, f64::from(max[a]) + margin);
        let count = f64::from(cells[a]);
        // A bit of headroom: rounding up each of the cells may move the last plane outwards.
        let quantum = exp2(floor_log2(low.abs().max(high.abs())) - 21);
        let corner = (low / quantum).floor() * quantum;
        let width = (((high - corner) / count) / quantum).ceil().max(1.0) * quantum;
        grid.corner[a] = corner as f32;
        grid.width[a] = width as f32;
        grid.inverse_width[a] = (1.0 / width) as f32;
    }
    grid
}

/// Triangles whose references are gathered before they are counted or listed, and the most references:
/// few enough that the cells they touch stay in a core's cache.
const BATCH: usize = 256;
const BATCH_REFERENCES: usize = 1 << 14;

/// How many triangles each cell will list, or `None` once they are more than `limit` in all.
fn count(vertices: &[f32], grid: &Grid, growth: f32, limit: u64) -> Option<Vec<AtomicU32>> {
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

/// Calls `f` with every triangle and each cell that lists it, a batch at a time, until it says false.
fn for_references(
    vertices: &[f32],
    grid: &Grid,
    growth: f32,
    counts: &[AtomicU32],
    f: impl Fn(&[(u32, u32)]) -> bool + Sync,
) {
    let goes_on = AtomicBool::new(true);
    let flush = |batch: &mut Vec<(u32, u32)>| {
        // An atomic addition waits for its cell to arrive from memory; loads before it overlap.
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
fn fill(vertices: &[f32], grid: Grid, growth: f32, counts: Vec<AtomicU32>) -> GridData {
    let mut references = 0;
    for count in &counts {
        references += count.swap(references, Ordering::Relaxed);
    }
    // Each list is filled in any order; its start moves to its end, which is the next one's start.
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

/// Sorts every list, so that the order of the fill does not show.
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

impl GridData {
    /// Bytes of the two lists.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        4 * (self.cells.len() as u64 + self.items.len() as u64)
    }

    /// The triangles that a cell lists; empty for a cell that the grid does not have.
    #[must_use]
    pub fn list(&self, cell: u32) -> &[u32] {
        let cell = cell as usize;
        match (self.cells.get(cell), self.cells.get(cell + 1)) {
            (Some(&first), Some(&end)) => &self.items[first as usize..end as usize],
            _ => &[],
        }
    }
}
