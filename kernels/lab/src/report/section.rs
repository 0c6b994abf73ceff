//! The table of a report's sections, in page order.

use std::pin::Pin;
use std::time::Duration;

use super::page::Part;
use super::work::Work;
use super::{choices, grid, left_out, moved, photon_maps, resolved, rules, samples, stiff, strategies};
use crate::Error;
use crate::tidy::Table;

/// A section: one CSV file, and a part of the page for every scene.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Name on the command line and in links of the page.
    pub name: &'static str,
    /// What it is, in a line, for the command line.
    pub help: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// Whether it is measured unless sections are named.
    pub is_default: bool,
    /// What is measured, as HTML.
    pub what: &'static str,
    /// Its CSV.
    pub file: &'static str,
    /// What a row of it is.
    pub row: &'static str,
    /// How long it typically takes, in seconds on two cores.
    pub seconds: f64,
    /// Whether it ends within the time that is asked for.
    pub is_bounded: bool,
    /// The CSV's columns.
    pub columns: &'static [&'static str],
    /// Measures a scene: adds rows, and returns the text of the page.
    pub(super) run: Run,
}

impl Section {
    /// The seconds that it typically takes, if it may take this long.
    pub(super) fn seconds_within(&self, time: Duration) -> f64 {
        if self.is_bounded { self.seconds.min(time.as_secs_f64()) } else { self.seconds }
    }
}

/// Measures a section.
#[derive(Clone, Copy, Debug)]
pub(super) enum Run {
    /// Never blocks: waits in a future, and lets other tasks run every few milliseconds.
    Future(for<'a> fn(&'a Work<'a>, &'a mut Table) -> Running<'a>),
    /// Blocks its thread while it waits for the device.
    Blocking(fn(&Work<'_>, &mut Table) -> Result<Part, Error>),
}

/// The future of a section.
pub(super) type Running<'a> = Pin<Box<dyn Future<Output = Result<Part, Error>> + Send + 'a>>;

/// All sections.
pub const SECTIONS: &[Section] = &[
    Section {
        name: "choices",
        help: "Time and wrong rays of every structure, schedule and set of rules",
        title: "Choices",
        is_default: true,
        what: "Every structure, schedule and set of rules on the same rays: one through a random point of each pixel, \
               or those of --rays-file. Runs are interleaved; ratios are to the recommended choice, the fastest robust and \
               accurate one, which is found in half of the rounds and compared in the other half (with fewer than twelve \
               rounds: in all). Where time is short, choices that are clearly slower get fewer runs, or only one. Other programs' methods have no runs to pair: their ratio is the \
               quotient of the times, its interval what both intervals allow.",
        file: "choices.csv",
        row: "a choice",
        seconds: 30.0,
        is_bounded: true,
        columns: choices::COLUMNS,
        run: Run::Future(|work, table| Box::pin(choices::run(work, table))),
    },
    Section {
        name: "rules",
        help: "What each numerical rule costs, and which rays are wrong without it",
        title: "Rules",
        is_default: true,
        what: "Robust numerics with one rule at a time left out, on rays aimed at the places where that may matter. \
               <em>tmax</em>: the t at which a ray leaves a cell is computed from the cell; without it, accumulated \
               along the walk. <em>acceptance</em>: a hit counts once no nearer one can follow; without it, only inside \
               the cell that is being tested. <em>triangle-test</em>: rays at edges are decided exactly; without it, \
               by Möller and Trumbore's test. <em>cell-growth</em>, <em>box-padding</em>: cells of the grid and boxes \
               of the BVH are enlarged by a bound on rounding errors; without it, they are not. <em>exact-order</em>, a rule \
               of --order exact only: the nearest hit is that at the smallest exact t; without it, by t as f32 has it, so that \
               some hits are undecided.",
        file: "rules.csv",
        row: "a set of rules, for all rays or a stratum",
        seconds: 20.0,
        is_bounded: true,
        columns: rules::COLUMNS,
        run: Run::Future(|work, table| Box::pin(rules::run(work, table))),
    },
    Section {
        name: "resolved",
        help: "Rays finished over time, pass by pass",
        title: "Rays finished over time",
        is_default: true,
        what: "How many rays have their final hit after each pass, and how many of these hits are wrong. Rays go through \
               the centres of pixels, so counts differ from those in section Choices.",
        file: "resolved.csv",
        row: "a pass of a configuration",
        seconds: 8.0,
        is_bounded: true,
        columns: resolved::COLUMNS,
        run: Run::Blocking(resolved::run),
    },
    Section {
        name: "moved",
        help: "Errors of the scene moved away from the origin",
        title: "Offset",
        is_default: true,
        what: "The scene moved away from the origin: error of t along the rays, as a distance relative to the \
               scene's extent, of the arithmetic alone and with rounding of the scene; and wrong rays by strata.",
        file: "moved.csv",
        row: "a place, a set of rules and a stratum of rays",
        seconds: 6.0,
        is_bounded: true,
        columns: moved::COLUMNS,
        run: Run::Blocking(moved::moved),
    },
    Section {
        name: "scaled",
        help: "Errors of the scene multiplied by 1e-20 to 1e20",
        title: "Scale",
        is_default: true,
        what: "The scene multiplied by 1e-20 to 1e20: error of t along the rays, as a distance relative to the scene's \
               extent, of the arithmetic alone and with rounding of the scene; and wrong rays by strata.",
        file: "scaled.csv",
        row: "a scale, a set of rules and a stratum of rays",
        seconds: 8.0,
        is_bounded: true,
        columns: moved::SCALED_COLUMNS,
        run: Run::Blocking(moved::scaled),
    },
    Section {
        name: "grid",
        help: "Time, memory and building time over the resolution of the grid",
        title: "Grid resolution",
        is_default: true,
        what: "Time, memory and building time over the resolution of the grid, with schedule compact and robust rules; \
               and after how many rays building a structure pays off.",
        file: "grid.csv",
        row: "a structure or resolution",
        seconds: 12.0,
        is_bounded: true,
        columns: grid::COLUMNS,
        run: Run::Blocking(grid::run),
    },
    Section {
        name: "samples",
        help: "Error of the image over samples per pixel",
        title: "Samples",
        is_default: true,
        what: "Root mean square error of the image over samples per pixel, from two: how fast it converges to the \
               limit of infinitely many samples.",
        file: "samples.csv",
        row: "a number of samples of a seed, or what quantity says",
        seconds: 20.0,
        is_bounded: true,
        columns: samples::COLUMNS,
        run: Run::Blocking(samples::run),
    },
    Section {
        name: "strategies",
        help: "Error of paths over time, by strategy and by structure, if a surface emits light",
        title: "Strategies of paths",
        is_default: true,
        what: "The image along paths (--integrator path): its error and FLIP over the time that it takes, for every way to find \
               light (--strategy) and every structure. Only in scenes in which a surface emits light.",
        file: "strategies.csv",
        row: "a number of samples of a seed and a strategy, or what quantity says",
        seconds: 15.0,
        is_bounded: true,
        columns: strategies::COLUMNS,
        run: Run::Blocking(strategies::run),
    },
    Section {
        name: "photon-maps",
        help: "Error of photon maps over time beside paths, bias and variance apart, if a surface emits light",
        title: "Photon maps",
        is_default: true,
        what: "The image by maps of photons (--integrator photons) beside that along paths: its error and FLIP over the time that it \
               takes, by each way to gather photons (--gather) and for growing numbers of iterations; and which part of the error \
               is bias, which more seeds do not take away, and which is variance. Paths, which the reference is along, find caustics of lamps with an \
               area only; so only in scenes in which a surface emits light.",
        file: "photon_maps.csv",
        row: "a number of samples of a seed and a way to estimate light, or what quantity says",
        seconds: 20.0,
        is_bounded: true,
        columns: photon_maps::COLUMNS,
        run: Run::Blocking(photon_maps::run),
    },
    Section {
        name: "left-out",
        help: "What is saved by leaving out code that this scene does not need",
        title: "Left out",
        is_default: true,
        what: "What the plan omits because this scene and view do not need it, and what putting back each item, and \
               all of them together, costs: memory and, on a GPU, run time and start-up.",
        file: "left_out.csv",
        row: "an item, with an accelerator and a schedule",
        seconds: 25.0,
        is_bounded: true,
        columns: left_out::COLUMNS,
        run: Run::Blocking(left_out::run),
    },
    Section {
        name: "stiff",
        help: "Time and tests in scenes that get harder in one way; up to 20 minutes whatever --seconds says, and only if it is named",
        title: "Stiffness",
        is_default: false,
        what: "Time and tests in scenes that get harder in one way, for every structure with and without each rule, and where \
               this scene stands among them by its stiffness number.",
        file: crate::stiff::CSV,
        row: "a structure with or without a rule, at a point of a family or in the scene",
        seconds: 900.0,
        is_bounded: false,
        columns: stiff::COLUMNS,
        run: Run::Blocking(stiff::run),
    },
];
