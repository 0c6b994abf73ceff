//! Halves the cells of the top level as long as rays gain by it.

use super::layout::Layout;
use super::map::{Map, Tree};
use super::{Division, Draft, Span};
use crate::numbers::parallel::map_ranges;
use crate::shared::grid_walk::Grid;
use crate::structures::grid::overlap;
use crate::structures::grid::{self, CountedGrid, GridData, GridError};

/// Cells into which a top-level cell is divided for each of its triangles, all of the same size, except that those with
/// at most one triangle are left whole.
pub(crate) const CELLS_PER_REFERENCE: u64 = 10;

/// Longer lists are divided even then only if rays gain by it: they may be of triangles that no division separates.
pub(crate) const LONG: usize = 64;

/// Beyond that, cells with longer lists than this are divided further where rays gain by it.
pub(crate) const SHORT: usize = 8;

/// References to which those of a top-level cell may grow, for each, and for all together. Where lists hardly become
/// shorter (many triangles at one place, slivers aslant), the budget ends the division.
pub(crate) const GROWTH: u64 = 12;
pub(crate) const GROWTH_OF_ALL: u64 = 64;

/// A cell of a uniform grid with a longer list than this is crowded.
pub(crate) const CROWDED: u64 = 16;

/// Cost of a step from cell to cell, in quarters of a triangle test.
pub(crate) const STEP_COST: usize = 2;

/// Trees of consecutive top-level cells, and their leaves.
struct Part {
    trees: Vec<Tree>,
    draft: Draft,
}

struct Refiner<'a> {
    vertices: &'a [f32],
    layout: &'a Layout,
    grids: Vec<Grid>,
    division: Division,
}

/// Most references of the top level, for each triangle and for all together, unless it is a single cell.
const MOST_AT_TOP: u64 = 16;
const MOST_AT_TOP_OF_ALL: u64 = 1 << 16;

/// Counts the lists of the top level.
///
/// # Errors
/// If they are longer than triangles much larger than its cells should make them, or than the executor can hold.
pub(super) fn count_top_lists(vertices: &[f32], layout: &Layout, most_words: u64) -> Result<CountedGrid, GridError> {
    let triangles = (vertices.len() / 9) as u64;
    let most =
        if layout.is_one_cell() { most_words } else { most_words.min(MOST_AT_TOP * triangles + MOST_AT_TOP_OF_ALL) };
    grid::counted(layout.at(0), layout.growth, vertices, most.min(u64::from(u32::MAX)))
}

/// The cells of all octrees, and the map that leads to them.
pub(super) fn refine(vertices: &[f32], layout: &Layout, lists: &GridData, division: Division) -> (Map, Draft) {
    let top = layout.at(0);
    let grids = (0..=layout.levels).map(|level| layout.at(level)).collect();
    let refiner = Refiner { vertices, layout, grids, division };
    let parts = map_ranges(lists.cells.len() - 1, 64, |range| {
        let mut part = Part { trees: Vec::new(), draft: Draft { spans: Vec::new(), lists: Vec::new() } };
        for cell in range {
            let list = lists.list(cell as u32).to_vec();
            let budget = GROWTH * list.len() as u64 + GROWTH_OF_ALL;
            let even = match division {
                Division::OfCrowded if list.len() as u64 <= CROWDED => 0,
                _ => even_levels(list.len() as u64),
            };
            let tree = refiner.divide((0, even), top.cell_of_index(cell as u32), list, budget, &mut part.draft);
            part.trees.push(tree);
        }
        part
    });
    let mut draft = Draft { spans: Vec::new(), lists: Vec::new() };
    let mut trees = Vec::new();
    for part in parts {
        let first = draft.spans.len() as u32;
        trees.extend(part.trees.into_iter().map(|tree| (first, tree)));
        draft.spans.extend(part.draft.spans);
        draft.lists.extend(part.draft.lists);
    }
    (Map::new(layout, &trees), draft)
}

impl Refiner<'_> {
    /// Divides a cell of a level, of those down to which its octree is divided anyway. The octree may have up to
    /// `budget` references below that, shared by the halves as they need it.
    fn divide(
        &self,
        (level, even): (u32, u32),
        cell: [i32; 3],
        list: Vec<u32>,
        budget: u64,
        draft: &mut Draft,
    ) -> Tree {
        if let Some((children, after)) = self.halves((level, even), cell, &list, budget) {
            let below = |i: usize| [0, 1, 2].map(|a| 2 * cell[a] + (i >> a & 1) as i32);
            let mut children = children.into_iter().enumerate();
            let trees = [(); 8].map(|()| {
                let (i, list) = children.next().unwrap_or_default();
                let share = budget * list.len() as u64 / after.max(1);
                self.divide((level + 1, even), below(i), list, share, draft)
            });
            return Tree::Node(Box::new(trees));
        }
        let shift = self.layout.levels - level;
        draft.spans.push(Span { low: cell.map(|v| v << shift), high: cell.map(|v| (v + 1) << shift) });
        draft.lists.push(list);
        Tree::Leaf(draft.spans.len() as u32 - 1)
    }

    /// The lists of the eight halves, x fastest, and their length, if the cell is to be divided: because its level is
    /// one of those, or because rays gain by it within the budget. A ray through the cell crosses a quarter of its
    /// halves, in proportion to their surface.
    fn halves(
        &self,
        (level, even): (u32, u32),
        cell: [i32; 3],
        list: &[u32],
        budget: u64,
    ) -> Option<([Vec<u32>; 8], u64)> {
        let short = match (level < even, self.division) {
            (true, _) => 1,
            (false, Division::ByContent) => SHORT,
            (false, Division::OfCrowded) => return None,
        };
        if list.len() <= short || level == self.layout.levels {
            return None;
        }
        let mut halves: [Vec<u32>; 8] = Default::default();
        let grid = &self.grids[level as usize + 1];
        for &triangle in list {
            let corners = &self.vertices[9 * triangle as usize..9 * triangle as usize + 9];
            let mut mask = overlap::halves(grid, f64::from(self.layout.growth), corners, cell);
            while mask != 0 {
                halves[mask.trailing_zeros() as usize].push(triangle);
                mask &= mask - 1;
            }
        }
        let after: usize = halves.iter().map(Vec::len).sum();
        let is_gain = after + STEP_COST < 4 * list.len() && after as u64 <= budget;
        (is_gain || level < even && list.len() <= LONG).then_some((halves, after as u64))
    }
}

/// Levels with about [`CELLS_PER_REFERENCE`] cells for each of these references: rounded, in integers.
pub(crate) fn even_levels(references: u64) -> u32 {
    // The most for which 8^(levels - 1/2) ≤ cells: squared, and as powers of 2.
    let squared = (CELLS_PER_REFERENCE * references).saturating_pow(2);
    squared.checked_ilog2().map_or(0, |log| (log + 3) / 6)
}
