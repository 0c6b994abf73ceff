//! The sets of elements of this program. A set named `all_…` has one element, for the total of the whole set.

use crate::programs::primitives::{blocks, tallies};
use crate::shared::launch::BLOCK;
use crate::tables::elements::{Count, Elements};

/// The scene's triangles.
pub static TRIANGLES: Elements = Elements { name: "triangles", count: Count::Given };
/// Blocks of triangles, in which spans are summed.
pub static TRIANGLE_BLOCKS: Elements = blocks("triangle_blocks", "triangles");
/// All triangles.
pub static ALL_TRIANGLES: Elements = blocks("all_triangles", "triangle_blocks");
/// A span: up to 32 cells along x in one row of a triangle's box.
pub static SPANS: Elements = Elements { name: "spans", count: Count::Found { in_stream: "spans_in_all", layer: 0 } };
/// Blocks of spans, in which references are summed.
pub static SPAN_BLOCKS: Elements = blocks("span_blocks", "spans");
/// All spans.
pub static ALL_SPANS: Elements = blocks("all_spans", "span_blocks");
/// A reference: a triangle in a cell.
pub static REFERENCES: Elements =
    Elements { name: "references", count: Count::Found { in_stream: "references_in_all", layer: 0 } };
/// A tally: how often a digit occurs in a block of references.
pub static TALLIES: Elements = tallies("tallies", "references");
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

const fn found(name: &'static str, in_stream: &'static str, layer: usize) -> Elements {
    Elements { name, count: Count::Found { in_stream, layer } }
}

/// Groups of cells: those of a workgroup.
pub static CELL_GROUPS: Elements =
    Elements { name: "cell_groups", count: Count::Per { of: "cells", per: BLOCK as u32, each: 1 } };

/// The build as a whole.
pub static WHOLE: Elements = Elements { name: "whole", count: Count::Given };
/// A leaf of an octree, later a cell that was merged of leaves.
pub static LEAVES: Elements = found("leaves", "totals", 0);
/// What the leaves are replaced by: halves, or merged cells.
pub static NEXT_LEAVES: Elements = found("next_leaves", "totals", 0);
/// Blocks of leaves.
pub static LEAF_BLOCKS: Elements = blocks("leaf_blocks", "leaves");
/// All leaves.
pub static ALL_LEAVES: Elements = blocks("all_leaves", "leaf_blocks");
/// A reference to a leaf.
pub static LISTED: Elements = found("listed", "totals", 1);
/// What these are replaced by.
pub static NEXT_LISTED: Elements = found("next_listed", "totals", 1);
/// Leaves that may still be divided.
pub static LEFT: Elements = found("left", "totals", 2);
/// Groups of 32 references to leaves.
pub static GROUPS: Elements = Elements { name: "groups", count: Count::Per { of: "listed", per: 32, each: 1 } };
/// Blocks of groups.
pub static GROUP_BLOCKS: Elements = blocks("group_blocks", "groups");
/// All groups.
pub static ALL_GROUPS: Elements = blocks("all_groups", "group_blocks");
/// The leaves before any are merged.
pub static REFINED: Elements = found("refined", "totals", 0);
/// A node of an octree: a cell that was divided.
pub static NODES: Elements = found("nodes", "nodes_in_all", 0);
/// Children of nodes.
pub static BRANCHES: Elements = Elements { name: "branches", count: Count::Per { of: "nodes", per: 1, each: 8 } };
/// Blocks of nodes.
pub static NODE_BLOCKS: Elements = blocks("node_blocks", "nodes");
/// All nodes.
pub static ALL_NODES: Elements = blocks("all_nodes", "node_blocks");
/// Entries of the voxel map's blocks.
pub static ENTRIES: Elements = found("entries", "entries_in_all", 0);
/// Blocks of these entries.
pub static ENTRY_BLOCKS: Elements = blocks("entry_blocks", "entries");
/// Blocks of references.
pub static REFERENCE_BLOCKS: Elements = blocks("reference_blocks", "references");
/// Blocks of references to leaves.
pub static LISTED_BLOCKS: Elements = blocks("listed_blocks", "listed");
/// One element if another round of merging follows.
pub static ROUNDS_AHEAD: Elements = found("rounds_ahead", "round", 3);

/// Every set.
pub static ELEMENTS: [&Elements; 35] = [
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
    &CELL_GROUPS,
    &WHOLE,
    &LEAVES,
    &NEXT_LEAVES,
    &LEAF_BLOCKS,
    &ALL_LEAVES,
    &LISTED,
    &NEXT_LISTED,
    &LEFT,
    &GROUPS,
    &GROUP_BLOCKS,
    &ALL_GROUPS,
    &REFINED,
    &NODES,
    &BRANCHES,
    &NODE_BLOCKS,
    &ALL_NODES,
    &ENTRIES,
    &ENTRY_BLOCKS,
    &REFERENCE_BLOCKS,
    &LISTED_BLOCKS,
    &ROUNDS_AHEAD,
];
