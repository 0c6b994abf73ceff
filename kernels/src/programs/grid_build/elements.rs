//! The elements of this program: triangles, pieces of their boxes, references to cells, and cells.

use super::radix::DIGITS;
use super::scan::SCAN_BLOCK;
use crate::shared::launch::BLOCK;
use crate::tables::elements::{Count, Elements};

const fn blocks(name: &'static str, of: &'static str) -> Elements {
    Elements { name, count: Count::Per { of, per: SCAN_BLOCK as u32, each: 1 } }
}

/// The scene's triangles.
pub static TRIANGLES: Elements = Elements { name: "triangles", count: Count::Given };
/// Blocks of triangles, in which spans are summed.
pub static TRIANGLE_BLOCKS: Elements = blocks("triangle_blocks", "triangles");
/// All triangles.
pub static ALL_TRIANGLES: Elements = blocks("all_triangles", "triangle_blocks");
/// A span: up to 32 cells along x in one row of a triangle's box.
pub static SPANS: Elements = Elements { name: "spans", count: Count::Found { in_stream: "spans_in_all" } };
/// Blocks of spans, in which references are summed.
pub static SPAN_BLOCKS: Elements = blocks("span_blocks", "spans");
/// All spans.
pub static ALL_SPANS: Elements = blocks("all_spans", "span_blocks");
/// A reference: a triangle in a cell.
pub static REFERENCES: Elements =
    Elements { name: "references", count: Count::Found { in_stream: "references_in_all" } };
/// A tally: how often a digit occurs in a block of references.
pub static TALLIES: Elements =
    Elements { name: "tallies", count: Count::Per { of: "references", per: BLOCK as u32, each: DIGITS as u32 } };
/// Blocks of tallies.
pub static TALLY_BLOCKS: Elements = blocks("tally_blocks", "tallies");
/// All tallies.
pub static ALL_TALLIES: Elements = blocks("all_tallies", "tally_blocks");
/// The grid's cells.
pub static CELLS: Elements = Elements { name: "cells", count: Count::Given };
/// Blocks of cells, in which the lengths of lists are summed.
pub static CELL_BLOCKS: Elements = blocks("cell_blocks", "cells");
/// All cells.
pub static ALL_CELLS: Elements = blocks("all_cells", "cell_blocks");

/// Every set.
pub static ELEMENTS: [&Elements; 13] = [
    &TRIANGLES,
    &TRIANGLE_BLOCKS,
    &ALL_TRIANGLES,
    &SPANS,
    &SPAN_BLOCKS,
    &ALL_SPANS,
    &REFERENCES,
    &TALLIES,
    &TALLY_BLOCKS,
    &ALL_TALLIES,
    &CELLS,
    &CELL_BLOCKS,
    &ALL_CELLS,
];
