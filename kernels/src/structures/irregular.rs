//! The irregular grid (Pérard-Gayot, Kalojanov and Slusallek, 2017): cells of many sizes on one fine virtual grid.
//!
//! ```text
//! irregular_map    u32      voxel map: for each top-level cell, and in blocks below: see [`cell_entry`] and
//!                           [`block_entry`]
//! irregular_cells  16 bytes per cell, see [`IrregularCell`]
//! irregular_items  u32      triangle ids, ascending within a cell; bit 31 marks the last of a list
//! ```
//!
//! 1. A coarse uniform grid lists the triangles (`layout`, `refine`). Its cells follow the root of the number of triangles.
//! 2. Each of its cells is divided into cells of one size, by the number of triangles that it lists, and where lists are
//!    still long then, into smaller ones as long as rays gain by it: an octree whose depth follows from the cell's own
//!    content (`refine`). Its leaves are the cells. Cells of one size can be merged and expanded farther than others.
//! 3. Neighbours that form a box are merged if the surface area heuristic says so (`merge`).
//! 4. Each cell's box is expanded over neighbours that list nothing it does not list (`expand`): a ray leaves the
//!    expanded box at once. A voxel still belongs to one cell, so expanded boxes overlap.
//!
//! A few triangles much farther away than all others are set aside (`aside`): they are the list of cell 0, the space
//! around the grid, in which every ray begins, and the grid is laid out for the others alone.
//!
//! **Planes are exact.** Every box lies on planes of one virtual grid, which is laid out as the uniform grid's
//! (see [`crate::structures::grid`]).
//!
//! **Lists are conservative.** A cell lists every triangle that meets its box, grown by [`growth`](super::grid::growth);
//! a triangle that meets the grown expanded box meets the grown box of one of the cells below it, whose lists are
//! subsets of this cell's.
//!
//! **Decisions are made in integers**: lengths of lists, and areas in units of the virtual cells. Only whether a
//! triangle meets a cell is computed in f64, as for the uniform grid. So the result depends neither on the number of
//! threads nor on how a compiler rounds, and the program `grid-build` builds the same grid on any device.

mod aside;
pub(crate) mod expand;
pub(crate) mod layout;
mod map;
pub(crate) mod merge;
pub(crate) mod refine;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

use super::grid::{self, Corners, GridError};
pub use crate::shared::constants::{LAST_ITEM, NO_LIST, OUTSIDE};
use crate::shared::grid_walk::Grid;
pub use crate::shared::irregular_walk::{IrregularCell, block_entry, cell_entry};
pub(crate) use layout::Layout;

/// An irregular grid.
#[derive(Clone, Debug, PartialEq)]
pub struct IrregularData {
    /// The virtual grid: its cells are the finest.
    pub grid: Grid,
    /// The voxel map.
    pub map: Vec<u32>,
    /// The cells.
    pub cells: Vec<IrregularCell>,
    /// The lists; at least one entry, which an empty grid does not use.
    pub items: Vec<u32>,
    /// Length of the list of each cell; kernels find its end by [`LAST_ITEM`].
    pub lengths: Vec<u32>,
    /// Growth of each cell, in traced units.
    pub growth: f32,
    /// The box of the triangles that the grid lists.
    pub bounds: Corners,
    /// Bounds distances between these triangles and ray origins, see [`grid::reach`].
    pub reach: f32,
    /// Number of triangles set aside. If there are any, cell [`OUTSIDE`] lists them.
    pub aside: u32,
    /// Most cells that a ray visits: it crosses a plane on which a box ends between any two of them.
    pub most_visited: u64,
}

/// A box of virtual cells: the first, and the one after the last, along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Span {
    low: [i32; 3],
    high: [i32; 3],
}

/// Cells before they are numbered for good: the box and the list of each.
struct Draft {
    spans: Vec<Span>,
    lists: Vec<Vec<u32>>,
}

/// What an irregular grid is laid out for, before any list is filled.
pub(crate) struct Site<'a> {
    /// The triangles that it lists.
    pub(crate) vertices: Cow<'a, [f32]>,
    /// The others, ascending.
    pub(crate) aside: Vec<u32>,
    /// See [`IrregularData::bounds`] and [`IrregularData::reach`].
    pub(crate) extent: (Corners, f32),
    pub(crate) layout: Layout,
    /// The top level, its lists counted.
    top: grid::CountedGrid,
}

impl<'a> Site<'a> {
    /// See [`build`].
    pub(crate) fn new(
        vertices: &'a [f32],
        origins: Option<Corners>,
        is_grown: bool,
        most_words: u64,
    ) -> Result<Self, GridError> {
        let aside = aside::far_away(vertices);
        let vertices: Cow<'a, [f32]> = match aside.is_empty() {
            true => Cow::Borrowed(vertices),
            false => Cow::Owned(aside::without(vertices, &aside)),
        };
        let bounds = grid::bounds(&vertices);
        let reach = grid::reach(bounds, origins);
        let mut coarser = 0;
        loop {
            let layout = Layout::new(&vertices, reach, is_grown, coarser);
            match refine::count_top_lists(&vertices, &layout, most_words) {
                Ok(top) => return Ok(Self { vertices, aside, extent: (bounds, reach), layout, top }),
                Err(_) if layout.is_one_cell() => return Err(too_many(&vertices, most_words)),
                Err(_) => coarser += 1,
            }
        }
    }
}

fn too_many(vertices: &[f32], limit: u64) -> GridError {
    GridError::TooManyCells { triangles: vertices.len() / 9, limit }
}

/// Builds the irregular grid over `vertices` (nine floats per triangle, traced units). `origins` is the box of
/// ray origins, if they are known; `most_words` is the size of the executor's largest buffer.
///
/// # Errors
/// If a buffer would be larger.
pub fn build(
    vertices: &[f32],
    origins: Option<Corners>,
    is_grown: bool,
    most_words: u64,
) -> Result<IrregularData, GridError> {
    let Site { vertices, aside, extent, layout, top } = Site::new(vertices, origins, is_grown, most_words)?;
    let data = below(&vertices, &layout, &top.fill(&vertices), Division::ByContent, most_words)?;
    Ok(IrregularData { bounds: extent.0, reach: extent.1, ..data }.with_aside(&aside))
}

/// Builds the irregular grid, or that of two levels, of this layout, as far as triangles that are not set aside go.
///
/// # Errors
/// If a buffer would be larger than `most_words`.
pub(crate) fn build_laid_out(
    vertices: &[f32],
    layout: &Layout,
    by_content: bool,
    most_words: u64,
) -> Result<IrregularData, GridError> {
    let lists = grid::lists(&layout.at(0), layout.growth, vertices, most_words)?;
    let division = if by_content { Division::ByContent } else { Division::OfCrowded };
    below(vertices, layout, &lists, division, most_words)
}

/// Builds a uniform grid of `cells` over `vertices`, each of whose crowded cells holds a finer grid (as the two-level grids
/// of Kalojanov, Billeter and Slusallek, 2011): no cells are merged or expanded. `reach` bounds distances, see
/// [`grid::reach`].
///
/// # Errors
/// If a buffer would be larger than `most_words`.
pub fn build_two_levels(
    vertices: &[f32],
    cells: [u32; 3],
    reach: f32,
    is_grown: bool,
    most_words: u64,
) -> Result<IrregularData, GridError> {
    let layout = Layout::below(vertices, reach, is_grown, cells);
    let data = build_laid_out(vertices, &layout, false, most_words)?;
    Ok(IrregularData { bounds: grid::bounds(vertices), reach, ..data })
}

/// Everything below the top level, whose lists are given.
fn below(
    vertices: &[f32],
    layout: &Layout,
    lists: &grid::GridData,
    division: Division,
    most_words: u64,
) -> Result<IrregularData, GridError> {
    let (mut map, mut draft) = refine::refine(vertices, layout, lists, division);
    if division == Division::ByContent {
        draft = merge::merge(draft, &mut map, layout);
        draft.spans = expand::expand(&draft, &map);
    }
    laid_out(layout, map, draft, most_words).ok_or_else(|| too_many(vertices, most_words))
}

/// Which cells of the top level are divided, and how far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Division {
    /// All, by the number of triangles that they list, and where lists are still long then, as long as rays gain by it.
    ByContent,
    /// Those with long lists, into cells of one size.
    OfCrowded,
}

/// The buffers; `None` if one would be larger than `most_words`.
fn laid_out(layout: &Layout, map: map::Map, draft: Draft, most_words: u64) -> Option<IrregularData> {
    let references: u64 = draft.lists.iter().map(|list| list.len() as u64).sum();
    if references.max(4 * draft.spans.len() as u64).max(map.entries.len() as u64) > most_words {
        return None;
    }
    let mut items = Vec::with_capacity((references as usize).max(1));
    let listed = draft.spans.into_iter().zip(draft.lists);
    let mut lengths = Vec::with_capacity(listed.len());
    let cells: Vec<IrregularCell> = listed
        .map(|(span, list)| {
            let first = if list.is_empty() { NO_LIST } else { items.len() as u32 };
            lengths.push(list.len() as u32);
            items.extend(&list);
            if let Some(last) = items.last_mut().filter(|_| !list.is_empty()) {
                *last |= LAST_ITEM;
            }
            IrregularCell { low: span.low.map(|v| v as u16), high: span.high.map(|v| v as u16), first }
        })
        .collect();
    if items.is_empty() {
        items.push(LAST_ITEM);
    }
    Some(IrregularData::of_buffers(layout, map.entries, cells, items, lengths))
}

/// Number of planes on which boxes end, over all axes.
fn crossings(cells: &[IrregularCell]) -> u64 {
    let planes = |axis: usize| {
        let mut planes: Vec<u16> = cells.iter().flat_map(|cell| [cell.low[axis], cell.high[axis]]).collect();
        planes.sort_unstable();
        planes.dedup();
        planes.len() as u64
    };
    (0..3).map(planes).sum()
}

impl IrregularData {
    /// A grid whose buffers are given, without triangles set aside; its extent is not known yet.
    pub(crate) fn of_buffers(
        layout: &Layout,
        map: Vec<u32>,
        cells: Vec<IrregularCell>,
        items: Vec<u32>,
        lengths: Vec<u32>,
    ) -> Self {
        // One more for the space around the grid.
        let most_visited = crossings(&cells) + 2;
        let (grid, growth) = (layout.grid, layout.growth);
        let (bounds, reach) = ([[0.0; 3]; 2], 0.0);
        Self { grid, map, cells, items, lengths, growth, bounds, reach, aside: 0, most_visited }
    }

    /// The same with the triangles that were set aside, ascending: they are listed by cell [`OUTSIDE`], the space around
    /// the grid, before all others, and the triangles of the other lists get the ids that they have among all.
    pub(crate) fn with_aside(mut self, aside: &[u32]) -> Self {
        if aside.is_empty() {
            return self;
        }
        // The number of those set aside before each of the others, added to its id among these.
        let before: Vec<u32> = (0..).zip(aside).map(|(k, id)| id - k).collect();
        let count = aside.len() as u32;
        let is_empty = self.lengths.iter().all(|&length| length == 0);
        let listed = self.items.iter().filter(|_| !is_empty).map(|item| {
            let id = item & !LAST_ITEM;
            (id + before.partition_point(|&first| first <= id) as u32) | item & LAST_ITEM
        });
        let mut items: Vec<u32> = aside.iter().copied().chain(listed).collect();
        items[aside.len() - 1] |= LAST_ITEM;
        self.items = items;
        for cell in self.cells.iter_mut().filter(|cell| cell.first != NO_LIST) {
            cell.first += count;
        }
        let whole = IrregularCell { low: [0; 3], high: self.grid.cells.map(|n| n as u16), first: 0 };
        self.cells.insert(OUTSIDE as usize, whole);
        self.lengths.insert(OUTSIDE as usize, count);
        // Entries of cells have a depth of 0.
        for entry in self.map.iter_mut().filter(|entry| **entry & 3 == 0) {
            *entry = cell_entry((*entry >> 2) + 1);
        }
        self.aside = count;
        self.most_visited = crossings(&self.cells) + 2;
        self
    }

    /// The triangles that a cell, which must exist, lists.
    pub fn list(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        let (first, length) = (self.cells[cell as usize].first, self.lengths[cell as usize]);
        let range = if length == 0 { 0..0 } else { first as usize..(first + length) as usize };
        self.items[range].iter().map(|item| item & !LAST_ITEM)
    }

    /// The cell to which a virtual cell belongs.
    #[must_use]
    pub fn find(&self, voxel: [i32; 3]) -> u32 {
        crate::shared::irregular_walk::find(&self.grid, &self.map, voxel)
    }

    /// Size in bytes of the three buffers.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        4 * (self.map.len() as u64 + self.items.len() as u64) + 16 * self.cells.len() as u64
    }
}
