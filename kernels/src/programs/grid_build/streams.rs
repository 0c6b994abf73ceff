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
//! ```
//!
//! The other streams hold sums of blocks of 16,384 elements, and the sum of all.

use super::elements::{
    ALL_CELLS, ALL_SPANS, ALL_TALLIES, ALL_TRIANGLES, CELL_BLOCKS, CELLS, REFERENCES, SPAN_BLOCKS, SPANS, TALLIES,
    TALLY_BLOCKS, TRIANGLE_BLOCKS, TRIANGLES,
};
use crate::options::reasons::{Because, Reason, Run};
use crate::tables::stream::Meaning::{Count, Id};
use crate::tables::stream::{Stream, streams};

fn always(_: &Run<'_>) -> Reason {
    (Because::Options, "the cells have too few digits to sort by")
}

streams! {
    /// First and last cell that a triangle's bounding box touches.
    BOX of TRIANGLES: "box" U32 &["low_x", "low_y", "low_z", "high_x", "high_y", "high_z"], meaning: &[Id; 6],
        unit: "cell coordinates", unwritten: &[0; 6], why_absent: always;
    /// Number of spans of a triangle; after the scan, of all triangles before it.
    FIRST_SPAN of TRIANGLES: "first_span" U32 &["spans"], meaning: &[Count], unit: "count of spans", unwritten: &[0],
        why_absent: always;
    /// Number of spans of a block of triangles.
    SPANS_OF_BLOCK of TRIANGLE_BLOCKS: "spans_of_block" U32 &["spans"], meaning: &[Count], unit: "count of spans",
        unwritten: &[0], why_absent: always;
    /// Number of spans of all triangles.
    SPANS_IN_ALL of ALL_TRIANGLES: "spans_in_all" U32 &["spans"], meaning: &[Count], unit: "count of spans", unwritten: &[0],
        why_absent: always;
    /// The triangle whose box a span is part of.
    SPAN_TRIANGLE of SPANS: "span_triangle" U32 &["triangle"], meaning: &[Id], unit: "triangle id", unwritten: &[0],
        why_absent: always;
    /// The first cell of a span.
    SPAN_CELL of SPANS: "span_cell" U32 &["x", "y", "z"], meaning: &[Id; 3], unit: "cell coordinates", unwritten: &[0; 3],
        why_absent: always;
    /// Which cells of a span the triangle overlaps.
    MASK of SPANS: "mask" U32 &["cells"], meaning: &[Id], unit: "a bit for each cell along x", unwritten: &[0],
        why_absent: always;
    /// Number of cells of a span that the triangle overlaps; after the scan, of all spans before it.
    FIRST_REFERENCE of SPANS: "first_reference" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: always;
    /// Number of references of a block of spans.
    REFERENCES_OF_BLOCK of SPAN_BLOCKS: "references_of_block" U32 &["references"], meaning: &[Count],
        unit: "count of references", unwritten: &[0], why_absent: always;
    /// Number of references of all spans.
    REFERENCES_IN_ALL of ALL_SPANS: "references_in_all" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: always;
    /// A reference's cell, sorted by an even number of digits.
    CELL_EVEN of REFERENCES: "cell_even" U32 &["cell"], meaning: &[Id], unit: "1-D index of a cell", unwritten: &[0],
        why_absent: always;
    /// A reference's triangle, likewise.
    TRIANGLE_EVEN of REFERENCES: "triangle_even" U32 &["triangle"], meaning: &[Id], unit: "triangle id", unwritten: &[0],
        why_absent: always;
    /// A reference's cell, sorted by an odd number of digits.
    CELL_ODD of REFERENCES: "cell_odd" U32 &["cell"], meaning: &[Id], unit: "1-D index of a cell", unwritten: &[0],
        why_absent: always;
    /// A reference's triangle, likewise.
    TRIANGLE_ODD of REFERENCES: "triangle_odd" U32 &["triangle"], meaning: &[Id], unit: "triangle id", unwritten: &[0],
        why_absent: always;
    /// How often a digit occurs in a block of references, with the counts of a digit side by side; after the scan,
    /// where the first of these references goes.
    TALLY of TALLIES: "tally" U32 &["references"], meaning: &[Count], unit: "count of references", unwritten: &[0],
        why_absent: always;
    /// Number of references of a block of tallies.
    TALLY_OF_BLOCK of TALLY_BLOCKS: "tally_of_block" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: always;
    /// Number of references of all tallies.
    TALLY_IN_ALL of ALL_TALLIES: "tally_in_all" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: always;
    /// Index of a cell's first reference.
    BEGIN of CELLS: "begin" U32 &["reference"], meaning: &[Id], unit: "index of a reference", unwritten: &[0],
        why_absent: always;
    /// Index after a cell's last reference.
    END of CELLS: "end" U32 &["reference"], meaning: &[Id], unit: "index of a reference", unwritten: &[0],
        why_absent: always;
    /// Length of a cell's list; after the scan, where the list starts.
    START of CELLS: "start" U32 &["references"], meaning: &[Count], unit: "count of references", unwritten: &[0],
        why_absent: always;
    /// Number of references of a block of cells.
    STARTS_OF_BLOCK of CELL_BLOCKS: "starts_of_block" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: always;
    /// Number of references of all cells.
    STARTS_IN_ALL of ALL_CELLS: "starts_in_all" U32 &["references"], meaning: &[Count], unit: "count of references",
        unwritten: &[0], why_absent: always;
}
