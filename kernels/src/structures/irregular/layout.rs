//! The virtual grid and its levels.

use super::Span;
use crate::shared::build::{BY_CONTENT, Build, exact_axes};
use crate::shared::grid_walk::Grid;
use crate::structures::grid::resolution::cubes;
use crate::structures::grid::{bounds, growth, layout as planes};

/// Top-level cells, for the root of the number of triangles. Rays cross about as many cells in scenes of any size, so a
/// small scene gets more cells per triangle than a large one.
const TOP_PER_ROOT: f64 = 400.0;

/// Most virtual cells along an axis: a cell's box is stored in 16 bits per coordinate.
const MOST_VIRTUAL: u32 = 1 << 15;

/// Most halvings of a top-level cell.
const MOST_LEVELS: u32 = 12;

/// Where cells can be, and what their surfaces count.
pub(crate) struct Layout {
    pub(crate) grid: Grid,
    pub(crate) levels: u32,
    pub(crate) growth: f32,
    /// Width of a virtual cell along each axis, as an integer of at most 8 bits.
    weights: [u32; 3],
}

impl Layout {
    /// With a top level of about [`TOP_PER_ROOT`] · √triangles cells, made coarser along each axis to two thirds as
    /// many cells, so many times.
    pub(crate) fn new(vertices: &[f32], reach: f32, is_grown: bool, coarser: u32) -> Self {
        let (extent, finest) = extent(vertices, reach);
        let triangles = (vertices.len() / 9) as f64;
        let mut top = cubes((triangles.sqrt() * TOP_PER_ROOT).max(1.0), extent);
        top.iter_mut().zip(finest).for_each(|(n, finest)| *n = (*n).min(finest));
        for _ in 0..coarser {
            top = top.map(|n| (n * 2 / 3).max(1));
        }
        Self::below(vertices, reach, is_grown, top)
    }

    /// With a top level of so many cells.
    pub(crate) fn below(vertices: &[f32], reach: f32, is_grown: bool, top: [u32; 3]) -> Self {
        let ([min, max], margin) = (bounds(vertices), growth(reach));
        let (_, finest) = extent(vertices, reach);
        let levels_of = |a: usize| (finest[a] / top[a]).max(1).ilog2();
        let levels = (0..3).map(levels_of).max().unwrap_or(0).min(MOST_LEVELS);
        // A flat axis has as many levels as the others.
        let levels = (0..3).fold(levels, |levels, a| levels.min((MOST_VIRTUAL / top[a]).ilog2()));
        let grid = Grid { levels, ..planes(min, max, top.map(|n| n << levels), margin) };
        let widest = grid.width.iter().fold(0.0f32, |most, &width| most.max(width));
        let weights = grid.width.map(|width| ((f64::from(width) / f64::from(widest) * 255.0).round() as u32).max(1));
        Self { grid, levels, growth: if is_grown { margin } else { 0.0 }, weights }
    }

    /// The grid whose cells are 2 to the power of `levels − level` virtual cells wide.
    pub(crate) fn at(&self, level: u32) -> Grid {
        let coarser = self.levels - level;
        let scale = (1u32 << coarser) as f32;
        Grid {
            cells: self.grid.cells.map(|n| n >> coarser),
            width: self.grid.width.map(|width| width * scale),
            inverse_width: self.grid.inverse_width.map(|inverse| inverse / scale),
            levels: 0,
            ..self.grid
        }
    }

    /// The uniform for building it over so many triangles, divided by their content or where they are crowded.
    pub(crate) fn build(&self, triangles: u32, by_content: bool) -> Build {
        let levels = self.levels;
        Build {
            levels,
            weights: self.weights,
            // Those of the finest cells.
            flags: exact_axes(&self.grid) | if by_content { BY_CONTENT } else { 0 },
            ..Build::new(&self.at(0), self.growth, triangles)
        }
    }

    /// The layout whose top level a build has.
    pub(crate) fn of(build: &Build, top: &Grid) -> Self {
        let (levels, scale) = (build.levels, (1u32 << build.levels) as f32);
        let grid = Grid {
            levels,
            cells: top.cells.map(|n| n << levels),
            width: top.width.map(|width| width / scale),
            inverse_width: top.inverse_width.map(|inverse| inverse * scale),
            ..*top
        };
        Self { grid, levels, growth: build.growth, weights: build.weights }
    }

    /// Whether the top level is a single cell.
    pub(super) fn is_one_cell(&self) -> bool {
        self.at(0).cells == [1; 3]
    }

    /// Half of a box's surface area, in integers.
    pub(super) fn half_area(&self, span: &Span) -> u64 {
        let [x, y, z] = [0, 1, 2].map(|a| (span.high[a] - span.low[a]) as u64 * u64::from(self.weights[a]));
        x * y + y * z + z * x
    }
}

/// The sides of the scene's box, and how many cells they have room for: those not much larger than their growth would list
/// their neighbours' triangles too.
fn extent(vertices: &[f32], reach: f32) -> ([f64; 3], [u32; 3]) {
    let [min, max] = bounds(vertices);
    let extent = [0, 1, 2].map(|a| f64::from(max[a]) - f64::from(min[a]));
    let least = 8.0 * f64::from(growth(reach));
    (extent, extent.map(|e| (e / least).clamp(1.0, f64::from(MOST_VIRTUAL)) as u32))
}
