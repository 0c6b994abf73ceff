//! The sections of a report: a table, in the order of the page.

use super::page::Part;
use super::table::Table;
use super::work::Work;
use super::{factors, grid, left_out, moved, resolved, samples};
use crate::Error;

/// A section: one CSV, and a part of the page for every scene.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// On the command line, and in the page's links.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What is measured, as HTML.
    pub what: &'static str,
    /// Its CSV.
    pub file: &'static str,
    /// The CSV's columns.
    pub columns: &'static [&'static str],
    /// Measures a scene: adds rows, and says what they mean.
    pub(super) run: fn(&Work<'_>, &mut Table) -> Result<Part, Error>,
}

/// All of them.
pub const SECTIONS: &[Section] = &[
    Section {
        name: "resolved",
        title: "Resolution of rays",
        what: "Rays whose hit is decided, over the time since the run began, pass by pass: one run whose passes are timed, and one that is read \
               back after each pass.",
        file: "resolved.csv",
        columns: resolved::COLUMNS,
        run: resolved::run,
    },
    Section {
        name: "factors",
        title: "Factors",
        what: "Wrong rays over time, the robust rules with one of them exchanged for the paper's at a time. Bars are 95% \
               intervals (Wilson) of what as many rays tell of all such rays.",
        file: "factors.csv",
        columns: factors::COLUMNS,
        run: factors::run,
    },
    Section {
        name: "moved",
        title: "Offset",
        what: "The scene moved away from the origin: error of t along the rays, as a distance relative to the scene's \
               extent.",
        file: "moved.csv",
        columns: moved::COLUMNS,
        run: moved::moved,
    },
    Section {
        name: "scaled",
        title: "Scale",
        what: "The same of the scene in other units.",
        file: "scaled.csv",
        columns: moved::COLUMNS,
        run: moved::scaled,
    },
    Section {
        name: "grid",
        title: "Grid resolution",
        what: "Time, memory and time to build over the resolution of the grid, all with the same hits; and what a \
               structure costs before its first ray.",
        file: "grid.csv",
        columns: grid::COLUMNS,
        run: grid::run,
    },
    Section {
        name: "samples",
        title: "Samples",
        what: "The picture's root mean square error over time, from two samples a pixel on: how fast several samples \
               approach the picture that no number of them reaches.",
        file: "samples.csv",
        columns: samples::COLUMNS,
        run: samples::run,
    },
    Section {
        name: "left-out",
        title: "Left out",
        what: "What the plan leaves out because this scene and view do not need it, put back: the same rays with and \
               without, in turn.",
        file: "left_out.csv",
        columns: left_out::COLUMNS,
        run: left_out::run,
    },
];
