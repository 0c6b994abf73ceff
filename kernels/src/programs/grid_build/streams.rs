//! The streams of the build, in one table. All hold u32.
//!
//! ```text
//! of triangles   box                     first and last cell of the triangle's bounding box
//!                first_span              number of its spans, then index of the first
//! of spans       span_triangle           the triangle whose box it is part of
//!                span_cell               its first cell
//!                mask                    a bit for each of its cells that the triangle overlaps
//!                first_reference         number of these, then index of the first reference
//! of references  cell_even  cell_odd     1-D index of the cell; sorted from one to the other
//!                triangle_even …_odd     the triangle
//! of tallies     tally                   how often a digit occurs in a block, then where its references go
//! of cells       begin  end              where its references are
//!                start                   number of these, then where its list starts
//!
//! of leaves      space  list             its box, and which references it has
//!                division                how far it may be divided
//!                places                  what replaces it when leaves are divided
//!                kept                    the same when leaves are merged
//!                opened                  nodes that begin with it
//!                wished  wished_by       the neighbour it proposes to merge with, and who proposes that to it
//!                expanded  cell          its expanded box, and the record that rays read
//! of listed      owner  item             a reference's leaf and triangle
//! of groups      bits  in_halves         in which halves of their leaf 32 references lie
//! of nodes       node                    a divided cell: its first leaf and its level
//!                first_entry             entries of the map's block that begins there, then before it
//!                block_levels            levels of that block
//! of branches    tree                    a child of a node
//! of cells       tree_top  map_top       the same for the top level; its entries of the voxel map
//! of entries     map_below               the voxel map's blocks
//! of refined     cell_of                 to which cell a leaf of the octrees belongs
//! of whole       totals                  numbers of leaves and references
//!                halving  round          how far halving and merging have got
//! of blocks      …_faults                numbers of faults in the result; all must be 0
//! ```
//!
//! What begins with `next_` becomes the stream of this name before the next step: nothing is copied.
//!
//! The other streams hold sums of blocks of 8,192 elements, and the sum of all. A scan replaces `places`, `kept` and `opened`
//! by the sums of the values before them in the same block; readers add what `…_of_block` has for the blocks before.

use super::elements::{
    ALL_CELLS, ALL_GROUPS, ALL_LEAVES, ALL_NODES, ALL_SPANS, ALL_TALLIES, ALL_TRIANGLES, BRANCHES, CELL_BLOCKS,
    CELL_GROUPS, CELLS, ENTRIES, ENTRY_BLOCKS, GROUP_BLOCKS, GROUPS, LEAF_BLOCKS, LEAVES, LISTED, LISTED_BLOCKS,
    NEXT_LEAVES, NEXT_LISTED, NODE_BLOCKS, NODES, REFERENCE_BLOCKS, REFERENCES, REFINED, SPAN_BLOCKS, SPANS, TALLIES,
    TALLY_BLOCKS, TRIANGLE_BLOCKS, TRIANGLES, WHOLE,
};
use super::reasons::{divided, every, irregular, uniform};
use crate::tables::stream::Meaning::{Count, Id};
use crate::tables::stream::{Stream, streams};

/// The halves of a cell, x fastest.
const HALVES: [&str; 8] = ["half_0", "half_1", "half_2", "half_3", "half_4", "half_5", "half_6", "half_7"];

streams! {
    /// First and last cell that a triangle's bounding box touches.
    BOX of TRIANGLES: "box" U32 &["low_x", "low_y", "low_z", "high_x", "high_y", "high_z"], meaning: &[Id; 6],
        unit: "cell coordinates", unwritten: &[0; 6], why_absent: every;
    /// Number of spans of a triangle; after the scan, of all triangles before it.
    FIRST_SPAN of TRIANGLES: "first_span" U32 &["spans"], meaning: &[Count], unit: "count of spans", unwritten: &[0],
        why_absent: every;
    /// Number of spans of a block of triangles.
    SPANS_OF_BLOCK of TRIANGLE_BLOCKS: "spans_of_block" U32 &["spans"], meaning: &[Count], unit: "count of spans",
        unwritten: &[0], why_absent: every;
    /// Number of spans of all triangles.
    SPANS_IN_ALL of ALL_TRIANGLES: "spans_in_all" U32 &["spans"], meaning: &[Count], unit: "count of spans", unwritten: &[0],
        why_absent: every;
    /// The triangle whose box a span is part of.
    SPAN_TRIANGLE of SPANS: "span_triangle" U32 &["triangle"], meaning: &[Id], unit: "triangle id", unwritten: &[0],
        why_absent: every;
    /// The first cell of a span.
    SPAN_CELL of SPANS: "span_cell" U32 &["x", "y", "z"], meaning: &[Id; 3], unit: "cell coordinates", unwritten: &[0; 3],
        why_absent: every;
    /// Which cells of a span the triangle overlaps.
    MASK of SPANS: "mask" U32 &["cells"], meaning: &[Id], unit: "a bit for each cell along x", unwritten: &[0],
        why_absent: every;
    /// Number of cells of a span that the triangle overlaps; after the scan, of all spans before it.
    FIRST_REFERENCE of SPANS: "first_reference" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: every;
    /// Number of references of a block of spans.
    REFERENCES_OF_BLOCK of SPAN_BLOCKS: "references_of_block" U32 &["references"], meaning: &[Count],
        unit: "count of references", unwritten: &[0], why_absent: every;
    /// Number of references of all spans.
    REFERENCES_IN_ALL of ALL_SPANS: "references_in_all" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: every;
    /// A reference's cell, sorted by an even number of digits.
    CELL_EVEN of REFERENCES: "cell_even" U32 &["cell"], meaning: &[Id], unit: "1-D index of a cell", unwritten: &[0],
        why_absent: every;
    /// A reference's triangle, likewise.
    TRIANGLE_EVEN of REFERENCES: "triangle_even" U32 &["triangle"], meaning: &[Id], unit: "triangle id", unwritten: &[0],
        why_absent: every;
    /// A reference's cell, sorted by an odd number of digits.
    CELL_ODD of REFERENCES: "cell_odd" U32 &["cell"], meaning: &[Id], unit: "1-D index of a cell", unwritten: &[0],
        why_absent: every;
    /// A reference's triangle, likewise.
    TRIANGLE_ODD of REFERENCES: "triangle_odd" U32 &["triangle"], meaning: &[Id], unit: "triangle id", unwritten: &[0],
        why_absent: every;
    /// How often a digit occurs in a block of references, with the counts of a digit side by side; after the scan,
    /// where the first of these references goes.
    TALLY of TALLIES: "tally" U32 &["references"], meaning: &[Count], unit: "count of references", unwritten: &[0],
        why_absent: every;
    /// Number of references of a block of tallies.
    TALLY_OF_BLOCK of TALLY_BLOCKS: "tally_of_block" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: every;
    /// Number of references of all tallies.
    TALLY_IN_ALL of ALL_TALLIES: "tally_in_all" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: every;
    /// Index of a cell's first reference.
    BEGIN of CELLS: "begin" U32 &["reference"], meaning: &[Id], unit: "index of a reference", unwritten: &[0],
        why_absent: every;
    /// Index after a cell's last reference.
    END of CELLS: "end" U32 &["reference"], meaning: &[Id], unit: "index of a reference", unwritten: &[0],
        why_absent: every;
    /// Length of a cell's list; after the scan, where the list starts.
    START of CELLS: "start" U32 &["references"], meaning: &[Count], unit: "count of references", unwritten: &[0],
        why_absent: every;
    /// Number of references of a block of cells.
    STARTS_OF_BLOCK of CELL_BLOCKS: "starts_of_block" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: every;
    /// Number of references of all cells.
    STARTS_IN_ALL of ALL_CELLS: "starts_in_all" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: every;
    /// Numbers of leaves and references after the last step, and of leaves that may still be divided.
    TOTALS of WHOLE: "totals" U32 &["leaves", "references", "left"], meaning: &[Count; 3], unit: "count", unwritten: &[0; 3],
        why_absent: divided;
    /// Most levels down to which an octree of a group of cells is divided anyway.
    DEPTH_OF_GROUP of CELL_GROUPS: "depth_of_group" U32 &["levels"], meaning: &[Count], unit: "halvings", unwritten: &[0],
        why_absent: divided;
    /// Of halving: how often it was done, and most levels down to which an octree is divided anyway.
    HALVING of WHOLE: "halving" U32 &["done", "depth"], meaning: &[Count; 2], unit: "halvings", unwritten: &[0; 2],
        why_absent: divided;
    /// A leaf's box, along each axis: its first virtual cell in the lower half of a word, the one after its last in the upper.
    SPACE of LEAVES: "space" U32 &["x", "y", "z"], meaning: &[Id; 3], unit: "virtual cells, 16 bits each", unwritten: &[0; 3],
        why_absent: divided;
    /// A leaf's list: its first reference, and how many it has.
    LIST of LEAVES: "list" U32 &["first", "length"], meaning: &[Id, Count], unit: "references", unwritten: &[0; 2],
        why_absent: divided;
    /// References to which those of a leaf may grow; its level in the lowest byte, the level down to which it is divided
    /// anyway in the next one, and bit 16 if it stays as it is.
    DIVISION of LEAVES: "division" U32 &["budget", "levels"], meaning: &[Count, Id], unit: "references; levels",
        unwritten: &[0; 2], why_absent: divided;
    /// Numbers of leaves and references that replace a leaf, and of those leaves that may still be divided; after the scan,
    /// sums over the earlier leaves of its block.
    PLACES of LEAVES: "places" U32 &["leaves", "references", "left"], meaning: &[Count; 3], unit: "count",
        unwritten: &[0; 3], why_absent: divided;
    /// Sums of blocks of leaves.
    PLACES_OF_BLOCK of LEAF_BLOCKS: "places_of_block" U32 &["leaves", "references", "left"], meaning: &[Count; 3],
        unit: "count", unwritten: &[0; 3], why_absent: divided;
    /// As `space`, of what replaces the leaves.
    NEXT_SPACE of NEXT_LEAVES: "next_space" U32 &["x", "y", "z"], meaning: &[Id; 3], unit: "virtual cells, 16 bits each",
        unwritten: &[0; 3], why_absent: divided;
    /// As `list`.
    NEXT_LIST of NEXT_LEAVES: "next_list" U32 &["first", "length"], meaning: &[Id, Count], unit: "references",
        unwritten: &[0; 2], why_absent: divided;
    /// As `division`.
    NEXT_DIVISION of NEXT_LEAVES: "next_division" U32 &["budget", "levels"], meaning: &[Count, Id],
        unit: "references; levels", unwritten: &[0; 2], why_absent: divided;
    /// The leaf that a reference belongs to.
    OWNER of LISTED: "owner" U32 &["leaf"], meaning: &[Id], unit: "index of a leaf", unwritten: &[0], why_absent: divided;
    /// Its triangle; at the end, bit 31 marks the last one of a list.
    ITEM of LISTED: "item" U32 &["triangle"], meaning: &[Id], unit: "triangle id", unwritten: &[0], why_absent: divided;
    /// As `owner`, of what replaces the references.
    NEXT_OWNER of NEXT_LISTED: "next_owner" U32 &["leaf"], meaning: &[Id], unit: "index of a leaf", unwritten: &[0],
        why_absent: divided;
    /// As `item`.
    NEXT_ITEM of NEXT_LISTED: "next_item" U32 &["triangle"], meaning: &[Id], unit: "triangle id", unwritten: &[0],
        why_absent: divided;
    /// For each half of their leaf, which of 32 references lie in it.
    BITS of GROUPS: "bits" U32 &HALVES, meaning: &[Id; 8], unit: "a bit for each reference", unwritten: &[0; 8],
        why_absent: divided;
    /// How many these are; after the scan, those of all groups before.
    IN_HALVES of GROUPS: "in_halves" U32 &HALVES, meaning: &[Count; 8], unit: "count of references", unwritten: &[0; 8],
        why_absent: divided;
    /// Sums of blocks of groups.
    IN_HALVES_OF_BLOCK of GROUP_BLOCKS: "in_halves_of_block" U32 &HALVES, meaning: &[Count; 8], unit: "count of references",
        unwritten: &[0; 8], why_absent: divided;
    /// Sums of all groups.
    IN_HALVES_IN_ALL of ALL_GROUPS: "in_halves_in_all" U32 &HALVES, meaning: &[Count; 8], unit: "count of references",
        unwritten: &[0; 8], why_absent: divided;
    /// Number of nodes whose first leaf this is; after the scan, sums over the earlier leaves of its block.
    OPENED of LEAVES: "opened" U32 &["nodes"], meaning: &[Count], unit: "count of nodes", unwritten: &[0],
        why_absent: divided;
    /// Sums of blocks of leaves.
    OPENED_OF_BLOCK of LEAF_BLOCKS: "opened_of_block" U32 &["nodes"], meaning: &[Count], unit: "count of nodes",
        unwritten: &[0], why_absent: divided;
    /// Number of all nodes.
    NODES_IN_ALL of ALL_LEAVES: "nodes_in_all" U32 &["nodes"], meaning: &[Count], unit: "count of nodes", unwritten: &[0],
        why_absent: divided;
    /// A node's first leaf, and its level.
    NODE of NODES: "node" U32 &["leaf", "level"], meaning: &[Id, Count], unit: "index of a leaf; halvings", unwritten: &[0; 2],
        why_absent: divided;
    /// A child of a node: twice the index of a leaf, or twice that of a node and 1.
    TREE of BRANCHES: "tree" U32 &["child"], meaning: &[Id], unit: "leaf or node", unwritten: &[0], why_absent: divided;
    /// The same for a cell of the top level.
    TREE_TOP of CELLS: "tree_top" U32 &["child"], meaning: &[Id], unit: "leaf or node", unwritten: &[0],
        why_absent: divided;
    /// Number of entries of the map's block that begins with a node; after the scan, of all nodes before it.
    FIRST_ENTRY of NODES: "first_entry" U32 &["entries"], meaning: &[Count], unit: "count of entries", unwritten: &[0],
        why_absent: divided;
    /// Levels that the block covers; 0 if none begins there.
    BLOCK_LEVELS of NODES: "block_levels" U32 &["levels"], meaning: &[Count], unit: "levels", unwritten: &[0],
        why_absent: divided;
    /// Sums of blocks of nodes.
    ENTRIES_OF_BLOCK of NODE_BLOCKS: "entries_of_block" U32 &["entries"], meaning: &[Count], unit: "count of entries",
        unwritten: &[0], why_absent: divided;
    /// Number of all entries.
    ENTRIES_IN_ALL of ALL_NODES: "entries_in_all" U32 &["entries"], meaning: &[Count], unit: "count of entries",
        unwritten: &[0], why_absent: divided;
    /// The voxel map of the top level.
    MAP_TOP of CELLS: "map_top" U32 &["entry"], meaning: &[Id], unit: "entry of the voxel map", unwritten: &[0],
        why_absent: divided;
    /// The voxel map's blocks.
    MAP_BELOW of ENTRIES: "map_below" U32 &["entry"], meaning: &[Id], unit: "entry of the voxel map", unwritten: &[0],
        why_absent: divided;
    /// To which cell each leaf of the octrees belongs.
    CELL_OF of REFINED: "cell_of" U32 &["cell"], meaning: &[Id], unit: "index of a cell", unwritten: &[0],
        why_absent: divided;
    /// Of merging: the axis, rounds that are over, leaves now, whether merging goes on, leaves at first.
    ROUND of WHOLE: "round" U32 &["axis", "rounds", "leaves", "goes_on", "refined"], meaning: &[Id, Count, Count, Id, Count],
        unit: "see the layers' names", unwritten: &[0; 5], why_absent: irregular;
    /// The neighbour that a leaf proposes to merge with, or the largest number; how many triangles both list.
    WISHED of LEAVES: "wished" U32 &["leaf", "shared"], meaning: &[Id, Count], unit: "index of a leaf; triangles",
        unwritten: &[u32::MAX, 0], why_absent: irregular;
    /// The leaf that proposes to merge with this one, or the largest number.
    WISHED_BY of LEAVES: "wished_by" U32 &["leaf"], meaning: &[Id], unit: "index of a leaf", unwritten: &[u32::MAX],
        why_absent: irregular;
    /// Numbers of leaves and references that replace a leaf when leaves are merged; after the scan, sums over the earlier
    /// leaves of its block.
    KEPT of LEAVES: "kept" U32 &["leaves", "references"], meaning: &[Count; 2], unit: "count", unwritten: &[0; 2],
        why_absent: irregular;
    /// Sums of blocks of leaves.
    KEPT_OF_BLOCK of LEAF_BLOCKS: "kept_of_block" U32 &["leaves", "references"], meaning: &[Count; 2], unit: "count",
        unwritten: &[0; 2], why_absent: irregular;
    /// As `space`, of the expanded box.
    EXPANDED of LEAVES: "expanded" U32 &["x", "y", "z"], meaning: &[Id; 3], unit: "virtual cells, 16 bits each",
        unwritten: &[0; 3], why_absent: irregular;
    /// A cell as rays read it: the corners of its box, 16 bits each, and its first item.
    CELL of LEAVES: "cell" U32 &["low_xy", "low_z_high_x", "high_yz", "first"], meaning: &[Id; 4],
        unit: "virtual cells, 16 bits each; index of an item", unwritten: &[0; 4], why_absent: divided;
    /// Lists that end before they start.
    START_FAULTS of CELL_BLOCKS: "start_faults" U32 &["faults"], meaning: &[Count], unit: "count of lists", unwritten: &[0],
        why_absent: uniform;
    /// References to triangles that do not exist.
    REFERENCE_FAULTS of REFERENCE_BLOCKS: "reference_faults" U32 &["faults"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: uniform;
    /// Cells whose box or list cannot be.
    CELL_FAULTS of LEAF_BLOCKS: "cell_faults" U32 &["faults"], meaning: &[Count], unit: "count of cells", unwritten: &[0],
        why_absent: divided;
    /// Items that are triangles which do not exist.
    ITEM_FAULTS of LISTED_BLOCKS: "item_faults" U32 &["faults"], meaning: &[Count], unit: "count of items", unwritten: &[0],
        why_absent: divided;
    /// Entries of the voxel map's top level that lead nowhere or back.
    TOP_FAULTS of CELL_BLOCKS: "top_faults" U32 &["faults"], meaning: &[Count], unit: "count of entries", unwritten: &[0],
        why_absent: divided;
    /// Entries of its blocks that do.
    ENTRY_FAULTS of ENTRY_BLOCKS: "entry_faults" U32 &["faults"], meaning: &[Count], unit: "count of entries",
        unwritten: &[0], why_absent: divided;
}

/// Faults that the last passes of a build count in what was built; there must be none.
pub const FAULTS: [Stream; 6] = [START_FAULTS, REFERENCE_FAULTS, CELL_FAULTS, ITEM_FAULTS, TOP_FAULTS, ENTRY_FAULTS];
