//! The uniform grid: its planes, its resolution, and which triangles each cell lists.
//!
//! ```text
//! grid_cells  u32  one per cell, x fastest, and one more: where the cell's list starts in grid_items
//! grid_items  u32  triangle ids, ascending within a cell; cell c owns cells[c] .. cells[c + 1]
//! ```
//!
//! **Planes are exact.** Kernels compute relative to the grid's corner, and the cell's width has so few bits that
//! `width * i` is never rounded, contracted or not. Where the scene's place allows, corner and width are multiples of one
//! quantum, a power of two chosen so that `corner + width * i` fits in 24 bits, too.
//!
//! **Lists are conservative.** A ray's computed position differs from its true one by at most [`growth`], 41 roundings
//! of 2⁻²⁴ of the largest distance along an axis between an origin and a corner: 8 in a crossing's t (origin relative to
//! the grid 1, difference 1, reciprocal 5, product 1), 5 in the entry point and its cell (origin 1, product 1, sum 1,
//! inverse width 2), and for the triangle 10 across the ray (its sheared corners) and 18 along it (its t), as in `raystep_lab::reference`. Every cell is grown by that much before the exact triangle/box test, so the cell that a
//! ray is computed to be in lists everything that the ray can hit there. Needles and triangles seen edge-on, whose t
//! moves by more than 18 roundings when their edge functions round, exceed this bound: there the grid may pick the
//! other of two triangles that f32 cannot distinguish, a tie.

mod distance;
mod lists;
pub(crate) mod overlap;
pub(super) mod resolution;
mod stats;

use std::sync::atomic::{AtomicU32, Ordering};

use crate::numbers::parallel::map_ranges;
use crate::numbers::units::{exp2, floor_log2};
pub use crate::options::GridSize;
use crate::shared::grid_walk::Grid;
pub use distance::distances;
use lists::{count, fill};
pub use resolution::{CELLS_PER_TRIANGLE, LEAPING_CELLS_PER_TRIANGLE, automatic_cells};
use resolution::{cubes, leaping};
pub use stats::GridStats;

/// The grid cannot be built.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GridError {
    /// A cell count of 0, or more cells than can be indexed.
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
    /// A buffer of an irregular grid would be larger than the executor's largest.
    #[error(
        "an irregular grid over {triangles} triangles would need more than the {limit} words that fit one buffer here: use --accelerator bvh"
    )]
    TooManyCells {
        /// Triangles of the scene.
        triangles: usize,
        /// Most words of a buffer.
        limit: u64,
    },
}

/// Most cells in all.
pub const MAX_CELLS: u64 = 1 << 28;

/// A grid with its lists.
#[derive(Clone, Debug, PartialEq)]
pub struct GridData {
    /// The uniform `grid`.
    pub grid: Grid,
    /// Start of each cell's list, and one entry more.
    pub cells: Vec<u32>,
    /// The lists.
    pub items: Vec<u32>,
    /// Growth of each cell, in traced units.
    pub growth: f32,
}

/// A box: its lower and its upper corner.
pub type Corners = [[f32; 3]; 2];

/// Growth of cells, in traced units, if no distance along an axis between two corners, or a corner and an origin,
/// exceeds `reach`.
#[must_use]
pub fn growth(reach: f32) -> f32 {
    41.0 * reach.max(f32::MIN_POSITIVE * 1e9) / (1 << 24) as f32
}

/// An upper bound on the distances along an axis between corners and between corners and origins, of which these are
/// the boxes: a power of two, so that a small camera movement does not change the grid.
#[must_use]
pub fn reach(corners: Corners, origins: Option<Corners>) -> f32 {
    let [low, high] = corners.map(|corner| corner.map(f64::from));
    let along = |axis: usize| {
        let origins = origins.map(|origins| origins.map(|corner| f64::from(corner[axis])));
        let [first, last] = origins.unwrap_or([low[axis], high[axis]]);
        (high[axis] - low[axis]).max(high[axis] - first).max(last - low[axis])
    };
    let distance = (0..3).map(along).fold(0.0, f64::max);
    exp2(floor_log2(distance.clamp(1e-30, 1e30)) + 1) as f32
}

/// A grid whose lists are counted but not filled: enough to tell whether filling is worthwhile.
#[derive(Debug)]
pub struct CountedGrid {
    grid: Grid,
    growth: f32,
    /// Length of each cell's list, and one more entry that is 0.
    counts: Vec<AtomicU32>,
}

impl CountedGrid {
    /// Whether most cells are empty: if only few are, looking for cells to skip costs more than it saves.
    #[must_use]
    pub fn is_sparse(&self) -> bool {
        let cells = self.counts.len();
        let empty = self.counts[..cells - 1].iter().filter(|count| count.load(Ordering::Relaxed) == 0).count();
        cells > 64 && 2 * empty > cells
    }

    /// The mean length of a list, each weighted by its length: about what a ray tests in the cell where it ends. A few
    /// cells that list most of the triangles make it large, and hardly change the plain mean.
    #[must_use]
    pub fn weighted_list(&self) -> f64 {
        let lengths = self.counts.iter().map(|count| f64::from(count.load(Ordering::Relaxed)));
        let (sum, squares) = lengths.fold((0.0, 0.0), |(sum, squares), n| (sum + n, squares + n * n));
        if sum > 0.0 { squares / sum } else { 0.0 }
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Growth of its cells, in traced units.
    #[must_use]
    pub fn growth(&self) -> f32 {
        self.growth
    }

    /// Cells along x, y and z.
    #[must_use]
    pub fn cells(&self) -> [u32; 3] {
        self.grid.cells.map(|n| n as u32)
    }

    /// Fills the list of each cell. `vertices` must be those that were counted.
    #[must_use]
    pub fn fill(self, vertices: &[f32]) -> GridData {
        fill(vertices, self.grid, self.growth, self.counts)
    }
}

/// Counts the lists of the grid over `vertices` (nine floats per triangle, traced units).
///
/// `reach` bounds distances, see [`reach()`]; `most_words` is the size of the executor's largest buffer. Without
/// `is_grown`, cells list only the triangles that they exactly meet, not those that [`growth`] adds.
///
/// # Errors
/// If the requested size, or the lists, cannot be indexed.
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
    let [min, max] = bounds(vertices);
    check_cells(cells)?;
    counted(layout(min, max, cells, growth.planes), growth.lists, vertices, most)
}

/// As [`count_lists`], with an automatic resolution for empty-space skipping.
///
/// # Errors
/// If the lists cannot be indexed.
pub fn count_lists_for_leaps(vertices: &[f32], reach: f32, most_words: u64) -> Result<CountedGrid, GridError> {
    let wanted = leaping((vertices.len() / 9) as u64);
    let growth = Growth { planes: growth(reach), lists: growth(reach) };
    automatic(vertices, |extent| cubes(wanted, extent), 64, growth, most_words.min(u64::from(u32::MAX)))
}

/// Builds the grid over `vertices`, see [`count_lists`].
///
/// # Errors
/// If the requested size, or the lists, cannot be indexed.
pub fn build(vertices: &[f32], size: GridSize, reach: f32, most_words: u64) -> Result<GridData, GridError> {
    Ok(count_lists(vertices, size, reach, true, most_words)?.fill(vertices))
}

/// Builds the grid for empty-space skipping over `vertices`, see [`count_lists_for_leaps`].
///
/// # Errors
/// If the lists cannot be indexed.
pub fn build_for_leaps(vertices: &[f32], reach: f32, most_words: u64) -> Result<GridData, GridError> {
    Ok(count_lists_for_leaps(vertices, reach, most_words)?.fill(vertices))
}

/// Counts and fills the lists of a grid whose planes and growth are given.
///
/// # Errors
/// If the lists cannot be indexed.
pub fn lists(grid: &Grid, growth: f32, vertices: &[f32], most_words: u64) -> Result<GridData, GridError> {
    Ok(counted(*grid, growth, vertices, most_words.min(u64::from(u32::MAX)))?.fill(vertices))
}

/// Counts the lists of a grid, with at most `limit` entries.
pub(super) fn counted(grid: Grid, growth: f32, vertices: &[f32], limit: u64) -> Result<CountedGrid, GridError> {
    let too_many = || GridError::TooManyReferences { cells: grid.cells.map(|n| n as u32), limit };
    let counts = count(vertices, &grid, growth, limit).ok_or_else(too_many)?;
    Ok(CountedGrid { grid, growth, counts })
}

/// Twice `planes` is the margin around the scene; cells are grown by `lists` when triangles are listed.
#[derive(Clone, Copy)]
struct Growth {
    planes: f32,
    lists: f32,
}

/// The resolution that `cells` chooses for the scene's extent, or a coarser one whose lists have at most `entries` per
/// triangle, and `most` in total.
fn automatic(
    vertices: &[f32],
    cells: impl Fn([f64; 3]) -> [u32; 3],
    entries: u64,
    growth: Growth,
    most: u64,
) -> Result<CountedGrid, GridError> {
    let [min, max] = bounds(vertices);
    let triangles = (vertices.len() / 9) as u64;
    let extent = [0, 1, 2].map(|a| f64::from(max[a]) - f64::from(min[a]));
    // Cells not much larger than their growth would list their neighbours' triangles too.
    let finest = extent.map(|e| (e / (8.0 * f64::from(growth.planes))).clamp(1.0, 4096.0) as u32);
    let mut cells = cells(extent);
    cells.iter_mut().zip(finest).for_each(|(n, finest)| *n = (*n).min(finest));
    let coarser = |cells: [u32; 3]| cells.map(|n| (n * 2 / 3).max(1));
    while cell_count(cells) >= most && cells != [1; 3] {
        cells = coarser(cells);
    }
    loop {
        let grid = layout(min, max, cells, growth.planes);
        // Triangles much larger than a cell would fill every list; then a coarser grid is cheaper.
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

/// Number of cells of a grid of this size.
///
/// # Errors
/// If it cannot be built.
pub fn check_cells(cells: [u32; 3]) -> Result<u64, GridError> {
    let count = cell_count(cells);
    if cells.iter().any(|&n| n == 0 || n > 4096) || count > MAX_CELLS {
        return Err(GridError::Size(cells));
    }
    Ok(count)
}

/// Lower and upper corner; the unit box if there are no triangles.
#[must_use]
pub fn bounds(vertices: &[f32]) -> Corners {
    const CHUNK: usize = 9 << 14;
    let parts = map_ranges(vertices.len(), CHUNK, |range| {
        vertices[range].chunks_exact(3).fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), p| {
            ([0, 1, 2].map(|a| low[a].min(p[a])), [0, 1, 2].map(|a| high[a].max(p[a])))
        })
    });
    let whole = parts
        .into_iter()
        .reduce(|a, b| ([0, 1, 2].map(|i| a.0[i].min(b.0[i])), [0, 1, 2].map(|i| a.1[i].max(b.1[i]))))
        .unwrap_or(([0.0; 3], [1.0; 3]));
    [whole.0, whole.1]
}

/// The cell's width is at least so many quanta, if planes are exact in the world's coordinates: rounding it up enlarges
/// the grid by less than 1/32.
const LEAST_QUANTA: f64 = 32.0;

/// Places the planes: the box of the scene with a margin of twice the growth, on exact planes.
pub(super) fn layout(min: [f32; 3], max: [f32; 3], cells: [u32; 3], growth: f32) -> Grid {
    let mut grid = Grid { cells: cells.map(|n| n as i32), ..Grid::default() };
    for a in 0..3 {
        let margin = 2.0 * f64::from(growth);
        let (low, high) = (f64::from(min[a]) - margin, f64::from(max[a]) + margin);
        let count = f64::from(cells[a]);
        // Some headroom: rounding up each cell's width may move the last plane outwards.
        let largest = floor_log2(low.abs().max(high.abs()));
        let quantum = exp2(largest - 21);
        let is_exact_in_the_world = (high - low) / count >= LEAST_QUANTA * quantum;
        let finest = if is_exact_in_the_world { quantum } else { exp2(largest - 23) };
        let corner = (low / finest).floor() * finest;
        let quantum = if is_exact_in_the_world { quantum } else { exp2(floor_log2(high - corner) - 21) };
        let width = (((high - corner) / count) / quantum).ceil().max(1.0) * quantum;
        grid.corner[a] = corner as f32;
        grid.width[a] = width as f32;
        grid.inverse_width[a] = (1.0 / width) as f32;
    }
    grid
}

impl GridData {
    /// Size in bytes of the two buffers.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        4 * (self.cells.len() as u64 + self.items.len() as u64)
    }

    /// The triangles that a cell lists; empty for a cell outside of the grid.
    #[must_use]
    pub fn list(&self, cell: u32) -> &[u32] {
        let cell = cell as usize;
        match (self.cells.get(cell), self.cells.get(cell + 1)) {
            (Some(&first), Some(&end)) => &self.items[first as usize..end as usize],
            _ => &[],
        }
    }
}
