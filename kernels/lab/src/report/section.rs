//! The table of a report's sections, in page order.

use super::page::Part;
use super::work::Work;
use super::{factors, grid, left_out, moved, resolved, samples};
use crate::Error;
use crate::tidy::Table;

/// A section: one CSV file, and a part of the page for every scene.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Name on the command line and in links of the page.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What is measured, as HTML.
    pub what: &'static str,
    /// Its CSV.
    pub file: &'static str,
    /// The CSV's columns.
    pub columns: &'static [&'static str],
    /// Measures a scene: adds rows, and returns the text of the page.
    pub(super) run: fn(&Work<'_>, &mut Table) -> Result<Part, Error>,
}

/// All sections.
pub const SECTIONS: &[Section] = &[
    Section {
        name: "resolved",
        title: "Resolution of rays",
        what: "Rays with a final hit after each pass, over the time since the start: one run with timed passes, and \
               one that is read back after each pass.",
        file: "resolved.csv",
        columns: resolved::COLUMNS,
        run: resolved::run,
    },
    Section {
        name: "factors",
        title: "Factors",
        what: "Wrong rays over time with robust numerics, with one rule at a time replaced by the paper's. Bars are \
               exact 95% intervals (Clopper and Pearson).",
        file: "factors.csv",
        columns: factors::COLUMNS,
        run: factors::run,
    },
    Section {
        name: "moved",
        title: "Offset",
        what: "The scene moved away from the origin: error of t along the rays, as a distance relative to the \
               scene's extent.",
        file: "moved.csv",
        columns: moved::COLUMNS,
        run: moved::moved,
    },
    Section {
        name: "scaled",
        title: "Scale",
        what: "The same for the scaled scene.",
        file: "scaled.csv",
        columns: moved::COLUMNS,
        run: moved::scaled,
    },
    Section {
        name: "grid",
        title: "Grid resolution",
        what: "Time, memory and building time over the resolution of the grid, all with the same hits; and the cost \
               of a structure before its first ray.",
        file: "grid.csv",
        columns: grid::COLUMNS,
        run: grid::run,
    },
    Section {
        name: "samples",
        title: "Samples",
        what: "Root mean square error of the image over time, from two samples per pixel: how fast it converges to \
               the limit of infinitely many samples.",
        file: "samples.csv",
        columns: samples::COLUMNS,
        run: samples::run,
    },
    Section {
        name: "left-out",
        title: "Left out",
        what: "The parts that the plan omits because this scene and view do not need them, restored: the same rays \
               with and without, interleaved.",
        file: "left_out.csv",
        columns: left_out::COLUMNS,
        run: left_out::run,
    },
];
