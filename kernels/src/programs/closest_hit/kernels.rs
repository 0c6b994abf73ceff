//! Every kernel, in one table: its WGSL, its twin, and the states it works on.

use super::elements::RAYS;
use super::states::{BACKGROUND, DONE, EXACT, ISECT_HIT, ISECT_NO_HIT, SHADE as SHADED, TRAV, TRAV_SETUP, UNWRITTEN};
use super::streams::no_exact_order;
use super::{HOME, PROGRAM, breaks, explain, rounding};
use crate::options::reasons::{Because, EYE_RAYS, GIVEN, NO_SHADE, ONE_SAMPLE, On, Passes, WALKED};
use crate::program::Kernel;
use crate::program::instance::kernels;
use crate::program::kernel::{Path, Proof};
use crate::program::rounding::Rounding;
use crate::shared::constants::{LIST_SIDE, WORKGROUP};
use crate::tables::kernel::{Counts, Launch, ListInfo, Role, Transition};
use crate::tables::state::Tag;

const fn send(from: Tag, when: &'static str, to: Tag) -> Transition {
    Transition { from, when, to }
}

/// Every list of live rays. With several steps per pass, both kernels share one list.
pub const LISTS: [ListInfo; 2] = [
    ListInfo { name: "intersect_list", slots: ["intersect_list_even", "intersect_list_odd"] },
    ListInfo { name: "traverse_list", slots: ["traverse_list_even", "traverse_list_odd"] },
];
const INTERSECT_LIST: Option<&str> = Some(LISTS[0].name);
const TRAVERSE_LIST: Option<&str> = Some(LISTS[1].name);

/// Where a step from cell to cell sends a ray.
const TO_CELLS: &[Transition] = &[
    send(TRAV, "next cell", ISECT_NO_HIT),
    send(TRAV, "next cell, hit kept", ISECT_HIT),
    send(TRAV, "leaves the grid", BACKGROUND),
    send(TRAV, "leaves the grid, hit kept", SHADED),
    send(TRAV, "leaves the grid, what is hit is open", EXACT),
];

// A kernel is two files, x.wgsl and x.rs, and one row here.
kernels! {
    /// Generates eye rays.
    GENERATE generate of RAYS, twin: element, {
        takes: &[UNWRITTEN],
        sends: &[
            send(UNWRITTEN, "every ray", TRAV_SETUP),
        ],
        role: Role::Source,
        workgroup: WORKGROUP,
        launch: Launch::Whole,
        counts: Counts::AllTo(TRAV_SETUP),
        resumes: |_| false,
        list: None,
        colour: [23, 150, 160],
        why_absent: |run| if run.features.eye_rays { EYE_RAYS } else { GIVEN },
        summary: "generates a ray for every pixel",
        explain: explain::of_generate,
        path: Path::Stays,
        rounding: rounding::OF_GENERATE,
        breaks: breaks::OF_GENERATE,
    }
    /// Finds a ray's first cell.
    SETUP setup of RAYS, twin: element, {
        takes: &[TRAV_SETUP],
        sends: &[
            send(TRAV_SETUP, "misses the grid's box", BACKGROUND),
            send(TRAV_SETUP, "enters the grid", ISECT_NO_HIT),
            send(TRAV_SETUP, "with a BVH: at its root", TRAV),
        ],
        role: Role::Enter,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: None,
        colour: [150, 120, 190],
        why_absent: |run| run.needed_only(On::Any, Passes::Stepped),
        summary: "finds where the ray's walk begins, or that it misses the grid",
        explain: explain::of_setup,
        path: Path::Enters,
        rounding: rounding::OF_SETUP,
        breaks: breaks::OF_SETUP,
    }
    /// Moves a ray to its next cell.
    TRAVERSE_GRID traverse_grid of RAYS, twin: element, {
        takes: &[TRAV],
        sends: TO_CELLS,
        role: Role::Step,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: TRAVERSE_LIST,
        colour: [66, 124, 200],
        why_absent: |run| run.needed_only(On::Grid, Passes::OneStep),
        summary: "moves the ray to its next cell",
        explain: explain::of_traverse_grid,
        path: Path::NextCell,
        rounding: rounding::OF_TRAVERSE_GRID,
        breaks: breaks::OF_TRAVERSE_GRID,
    }
    /// Moves a ray to its next cell of the irregular grid.
    TRAVERSE_IRREGULAR traverse_irregular of RAYS, twin: element, {
        takes: &[TRAV],
        sends: TO_CELLS,
        role: Role::Step,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: TRAVERSE_LIST,
        colour: [66, 124, 200],
        why_absent: |run| run.needed_only(On::Irregular, Passes::OneStep),
        summary: "moves the ray to its next cell of the irregular grid",
        explain: explain::of_traverse_irregular,
        path: Path::NextCell,
        rounding: rounding::OF_TRAVERSE_IRREGULAR,
        breaks: breaks::OF_TRAVERSE_IRREGULAR,
    }
    /// Moves a ray to its next node of the BVH.
    TRAVERSE_BVH traverse_bvh of RAYS, twin: element, {
        takes: &[TRAV],
        sends: &[
            send(TRAV, "inner node or box missed", TRAV),
            send(TRAV, "enters a leaf", ISECT_NO_HIT),
            send(TRAV, "enters a leaf, hit kept", ISECT_HIT),
            send(TRAV, "tree done", BACKGROUND),
            send(TRAV, "tree done, hit kept", SHADED),
            send(TRAV, "tree done, what is hit is open", EXACT),
        ],
        role: Role::Step,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: TRAVERSE_LIST,
        colour: [66, 124, 200],
        why_absent: |run| run.needed_only(On::Bvh, Passes::OneStep),
        summary: "moves the ray to its next node of the BVH",
        explain: explain::of_traverse_bvh,
        path: Path::NextNode,
        rounding: rounding::OF_TRAVERSE_BVH,
        breaks: breaks::OF_TRAVERSE_BVH,
    }
    /// Tests one triangle.
    INTERSECT intersect of RAYS, twin: element, {
        takes: &[ISECT_NO_HIT, ISECT_HIT],
        sends: &[
            send(ISECT_NO_HIT, "tested one triangle, no hit", ISECT_NO_HIT),
            send(ISECT_NO_HIT, "nearer hit", ISECT_HIT),
            send(ISECT_HIT, "tested one triangle", ISECT_HIT),
            send(ISECT_NO_HIT, "last triangle hit, within this cell", SHADED),
            send(ISECT_NO_HIT, "list ended, or last triangle hit beyond this cell", TRAV),
            send(ISECT_HIT, "list ended, t within this cell", SHADED),
            send(ISECT_HIT, "list ended, t beyond the cell's exit", TRAV),
            send(ISECT_NO_HIT, "without a grid: list ended, nothing hit", BACKGROUND),
            send(ISECT_NO_HIT, "list ended, what is hit is open", EXACT),
            send(ISECT_HIT, "list ended, what is hit is open", EXACT),
        ],
        role: Role::Test,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |features| features.resumes_scan,
        list: INTERSECT_LIST,
        colour: [232, 140, 60],
        why_absent: |run| run.needed_only(On::Any, Passes::OneStep),
        summary: "tests the ray against one triangle of its cell or leaf",
        explain: explain::of_intersect,
        path: Path::Stays,
        rounding: rounding::OF_INTERSECT,
        breaks: breaks::OF_INTERSECT,
    }
    /// Advances a ray by several steps.
    WALK walk of RAYS, twin: element, {
        takes: &[TRAV, ISECT_NO_HIT, ISECT_HIT],
        sends: &[
            send(ISECT_NO_HIT, "steps taken, nothing hit", ISECT_NO_HIT),
            send(ISECT_NO_HIT, "steps taken, a hit kept", ISECT_HIT),
            send(ISECT_HIT, "steps taken, the hit kept", ISECT_HIT),
            send(ISECT_NO_HIT, "nearest hit found", SHADED),
            send(ISECT_HIT, "nearest hit found", SHADED),
            send(ISECT_NO_HIT, "walk over, nothing hit", BACKGROUND),
            send(TRAV, "steps taken", TRAV),
            send(TRAV, "tree done, hit", SHADED),
            send(TRAV, "tree done, nothing hit", BACKGROUND),
            send(ISECT_NO_HIT, "walk over, what is hit is open", EXACT),
            send(ISECT_HIT, "walk over, what is hit is open", EXACT),
            send(TRAV, "tree done, what is hit is open", EXACT),
        ],
        role: Role::Walk,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |features| features.resumes,
        list: INTERSECT_LIST,
        colour: [190, 150, 30],
        why_absent: |_| WALKED,
        summary: "moves the ray by several cells or nodes",
        explain: explain::of_walk,
        path: Path::Several,
        rounding: rounding::OF_WALK,
        breaks: breaks::OF_WALK,
    }
    /// Traces a ray from its start to its hit.
    FUSED fused of RAYS, twin: element, {
        takes: &[TRAV_SETUP, TRAV, ISECT_NO_HIT, ISECT_HIT],
        sends: &[
            send(UNWRITTEN, "loop turns spent, in a list without a hit", ISECT_NO_HIT),
            send(UNWRITTEN, "loop turns spent, in a list, a hit kept", ISECT_HIT),
            send(UNWRITTEN, "loop turns spent, between nodes", TRAV),
            send(TRAV_SETUP, "loop turns spent, in a list without a hit", ISECT_NO_HIT),
            send(TRAV_SETUP, "loop turns spent, in a list, a hit kept", ISECT_HIT),
            send(TRAV_SETUP, "loop turns spent, between nodes", TRAV),
            send(ISECT_NO_HIT, "loop turns spent again", ISECT_NO_HIT),
            send(ISECT_NO_HIT, "loop turns spent again, a hit kept", ISECT_HIT),
            send(ISECT_NO_HIT, "hit", SHADED),
            send(ISECT_NO_HIT, "no hit", BACKGROUND),
            send(ISECT_HIT, "loop turns spent again", ISECT_HIT),
            send(ISECT_HIT, "hit", SHADED),
            send(TRAV, "loop turns spent again", TRAV),
            send(TRAV, "hit", SHADED),
            send(TRAV, "no hit", BACKGROUND),
            send(UNWRITTEN, "hit", SHADED),
            send(UNWRITTEN, "no hit", BACKGROUND),
            send(TRAV_SETUP, "hit", SHADED),
            send(TRAV_SETUP, "no hit", BACKGROUND),
            send(UNWRITTEN, "what is hit is open", EXACT),
            send(TRAV_SETUP, "what is hit is open", EXACT),
            send(ISECT_NO_HIT, "what is hit is open", EXACT),
            send(ISECT_HIT, "what is hit is open", EXACT),
            send(TRAV, "what is hit is open", EXACT),
        ],
        role: Role::Whole,
        workgroup: WORKGROUP,
        launch: Launch::Bands,
        counts: Counts::Anew,
        resumes: |features| features.resumes,
        list: None,
        // A walk that resumes takes indices from its streams, which the caller may have edited.
        proof: Proof::new(|data, features| !features.resumes && data.indices_hold(features)),
        colour: [200, 80, 140],
        why_absent: |run| run.needed_only(On::Any, Passes::Fused),
        summary: "takes the ray from its start to its nearest hit",
        explain: explain::of_fused,
        path: Path::Stays,
        rounding: rounding::OF_FUSED,
        breaks: breaks::OF_FUSED,
    }
    /// Decides in integers what a ray hits.
    DECIDE decide of RAYS, twin: element, {
        takes: &[EXACT],
        sends: &[
            send(EXACT, "loop turns spent", EXACT),
            send(EXACT, "hit", SHADED),
            send(EXACT, "no hit", BACKGROUND),
        ],
        role: Role::Walk,
        workgroup: WORKGROUP,
        launch: Launch::Bands,
        counts: Counts::Anew,
        resumes: |features| features.resumes,
        list: None,
        sets: &[("decides", true)],
        follows: &[("resumes", "resumes_exact")],
        colour: [220, 60, 60],
        why_absent: no_exact_order,
        summary: "traces the ray again, and decides in integers what it hits",
        explain: explain::of_decide,
        path: Path::Stays,
        rounding: rounding::OF_FUSED,
        breaks: breaks::OF_DECIDE,
    }
    /// Colours what was hit.
    SHADE shade of RAYS, twin: element, {
        takes: &[SHADED, BACKGROUND],
        sends: &[
            send(SHADED, "loop turns spent, lights are left", SHADED),
            send(SHADED, "shaded", DONE),
            send(BACKGROUND, "background", DONE),
        ],
        role: Role::Finish,
        workgroup: WORKGROUP,
        launch: Launch::Whole,
        counts: Counts::AllTo(DONE),
        resumes: |features| features.resumes_light,
        list: None,
        colour: [90, 165, 90],
        why_absent: |run| match run.options.shade {
            true => (Because::Options, "needed only with --integrator local: other kernels compute the light"),
            false => NO_SHADE,
        },
        summary: "colours the ray from its hit, or the background",
        explain: explain::of_shade,
        path: Path::Stays,
        rounding: rounding::OF_SHADE,
        breaks: breaks::OF_SHADE,
    }
    /// Adds a sample to its pixel's mean.
    ACCUMULATE accumulate of RAYS, twin: element, {
        takes: &[DONE],
        sends: &[
            send(DONE, "the pixel wants more samples", UNWRITTEN),
            send(DONE, "it was the last sample", DONE),
        ],
        role: Role::Sample,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: None,
        colour: [120, 130, 140],
        why_absent: |_| ONE_SAMPLE,
        summary: "adds the sample to its pixel's mean, and requests the next one",
        explain: explain::of_accumulate,
        path: Path::Stays,
        rounding: rounding::OF_ACCUMULATE,
        breaks: breaks::OF_ACCUMULATE,
    }
    /// Counts the rays in each state.
    COUNT count of RAYS, twin: element, {
        takes: &[],
        sends: &[],
        role: Role::Count,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::None,
        resumes: |_| false,
        list: None,
        colour: [120, 120, 120],
        why_absent: |_| (Because::Options, "needed only after a kernel that does not count the rays that it sends on, such as fused"),
        summary: "counts the rays in each state, after a kernel that does not",
        explain: explain::of_count,
        path: Path::Stays,
        rounding: Rounding::NONE,
        breaks: breaks::OF_COUNT,
    }
}

#[cfg(test)]
mod tests;
