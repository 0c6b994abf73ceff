//! The order of the build's kernels.

use super::instances::*;
use super::radix::digits_of;
use crate::program::Kernel;
use crate::program::schedule::{Schedule, Step};

/// What is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A uniform grid.
    Uniform,
    /// A uniform grid whose crowded cells hold finer ones.
    TwoLevels,
    /// An irregular grid.
    Irregular,
}

/// Up to the references, which are in the order of their triangles.
const COUNTED: [Kernel; 9] = [
    FIND_BOUNDS,
    SCAN_SPANS,
    SCAN_SPAN_BLOCKS,
    ADD_SPANS,
    TEST_SPANS,
    SCAN_REFERENCES,
    SCAN_REFERENCE_BLOCKS,
    ADD_REFERENCES,
    EMIT_REFERENCES,
];
const TALLIED: [Kernel; 3] = [SCAN_TALLIES, SCAN_TALLY_BLOCKS, ADD_TALLIES];
/// For each digit.
const SORTED: [[Kernel; 2]; 7] = [
    [HISTOGRAM_0, SCATTER_0],
    [HISTOGRAM_1, SCATTER_1],
    [HISTOGRAM_2, SCATTER_2],
    [HISTOGRAM_3, SCATTER_3],
    [HISTOGRAM_4, SCATTER_4],
    [HISTOGRAM_5, SCATTER_5],
    [HISTOGRAM_6, SCATTER_6],
];
/// After an even and after an odd number of digits.
const MARKED: [Kernel; 2] = [MARK_EVEN, MARK_ODD];
const STARTED: [Kernel; 4] = [MEASURE_LISTS, SCAN_STARTS, SCAN_START_BLOCKS, ADD_STARTS];
const TAKEN: [Kernel; 2] = [TAKE_EVEN, TAKE_ODD];
/// Halves leaves once.
const REFINED: [Kernel; 10] = [
    FIND_HALVES,
    SCAN_HALVES,
    SCAN_HALF_BLOCKS,
    ADD_HALVES,
    DECIDE_DIVISION,
    SCAN_PLACES,
    SCAN_PLACE_BLOCKS,
    DIVIDE_LEAVES,
    HAND_DOWN_LISTS,
    TURN_TO_NEXT_HALVING,
];
const MAPPED: [Kernel; 10] = [
    COUNT_NODES,
    SCAN_OPENED,
    SCAN_OPENED_BLOCKS,
    LINK_TREES,
    FIND_BLOCKS,
    SCAN_ENTRIES,
    SCAN_ENTRY_BLOCKS,
    ADD_ENTRIES,
    MAP_TOP_CELLS,
    MAP_ALL_BLOCKS,
];
/// Merges leaves along one axis.
const MERGED: [Kernel; 7] =
    [FIND_WISHES, UNITE_LEAVES, SCAN_KEPT, SCAN_KEPT_BLOCKS, GATHER_LEAVES, TURN_TO_NEXT_AXIS, FOLLOW_LEAVES];
const EXPANDED: [Kernel; 5] = [NAME_TOP, NAME_BLOCKS, EXPAND_CELLS, FINISH_EXPANDED, FINISH_LISTS];

const CHECKED: [Kernel; 4] = [CHECK_LISTS, CHECK_ALL_CELLS, CHECK_TOP, CHECK_BLOCKS];
const CHECKED_ITEMS: [Kernel; 2] = [CHECK_EVEN, CHECK_ODD];

/// The sets on which repetitions depend, by their index in the program's table.
const WHILE_SOME_ARE_LEFT: usize = 0;
const WHILE_ROUNDS_ARE_AHEAD: usize = 1;

/// The schedule for a grid whose top level, or only one, has so many cells.
#[must_use]
pub fn of(kind: Kind, cells: u32) -> Schedule {
    let digits = digits_of(cells) as usize;
    let run = |kernels: &[Kernel]| kernels.iter().copied().map(Step::Run).collect::<Vec<_>>();
    let mut steps = run(&COUNTED);
    for [count, scatter] in SORTED.into_iter().take(digits) {
        steps.extend(run(&[count]));
        steps.extend(run(&TALLIED));
        steps.extend(run(&[scatter]));
    }
    steps.extend(run(&[MARKED[digits % 2]]));
    steps.extend(run(&STARTED));
    if kind != Kind::Uniform {
        steps.extend(run(&[COUNT_TOP_LEVEL, MAKE_FIRST_LEAVES, FIND_DEPTH, TAKEN[digits % 2]]));
        steps.push(Step::RepeatWhileAny(WHILE_SOME_ARE_LEFT, run(&REFINED)));
        steps.extend(run(&MAPPED));
    }
    match kind {
        Kind::Uniform => steps.extend(run(&[CHECK_LIST_STARTS, CHECKED_ITEMS[digits % 2]])),
        Kind::TwoLevels => steps.extend(run(&[FINISH_LEAVES, FINISH_LISTS])),
        Kind::Irregular => {
            steps.extend(run(&[BEGIN_MERGING]));
            steps.push(Step::RepeatWhileAny(WHILE_ROUNDS_ARE_AHEAD, run(&MERGED)));
            steps.extend(run(&EXPANDED));
        }
    }
    if kind != Kind::Uniform {
        steps.extend(run(&CHECKED));
    }
    Schedule { steps }
}
