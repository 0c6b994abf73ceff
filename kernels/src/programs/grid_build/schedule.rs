//! The order of the build's kernels.

use super::elements::{LEFT, ROUNDS_AHEAD};
use super::instances::*;
use crate::program::Kernel;
use crate::program::schedule::{Count, Schedule, Step};
use crate::programs::primitives::radix::digits_of;

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
/// For a digit that is even, and for one that is odd: from one stream to the other, and back.
const SORTED: [[Kernel; 2]; 2] = [[HISTOGRAM_EVEN, SCATTER_EVEN], [HISTOGRAM_ODD, SCATTER_ODD]];
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

/// The schedule for a grid whose top level, or only one, has so many cells.
#[must_use]
pub fn of(kind: Kind, cells: u32) -> Schedule {
    let digits = digits_of(cells);
    let run = |kernels: &[Kernel]| kernels.iter().copied().map(Step::Run).collect::<Vec<_>>();
    let mut steps = run(&COUNTED);
    // Sorts by a digit, in a loop over pairs of digits.
    let sort = |digit: u32| {
        let [count, scatter] =
            SORTED[digit as usize % 2].map(|kernel| Step::RunBy(kernel, Count { first: digit, by: &[2] }));
        [vec![count], run(&TALLIED), vec![scatter]].concat()
    };
    steps.push(Step::Repeat("digit pair", Count::always(digits / 2), [sort(0), sort(1)].concat()));
    if !digits.is_multiple_of(2) {
        steps.extend(sort(digits - 1));
    }
    let digits = digits as usize;
    steps.extend(run(&[MARKED[digits % 2]]));
    steps.extend(run(&STARTED));
    if kind != Kind::Uniform {
        steps.extend(run(&[COUNT_TOP_LEVEL, MAKE_FIRST_LEAVES, FIND_DEPTH, TAKEN[digits % 2]]));
        steps.push(Step::RepeatWhileAny(&LEFT, run(&REFINED)));
        steps.extend(run(&MAPPED));
    }
    match kind {
        Kind::Uniform => steps.extend(run(&[CHECK_LIST_STARTS, CHECKED_ITEMS[digits % 2]])),
        Kind::TwoLevels => steps.extend(run(&[FINISH_LEAVES, FINISH_LISTS])),
        Kind::Irregular => {
            steps.extend(run(&[BEGIN_MERGING]));
            steps.push(Step::RepeatWhileAny(&ROUNDS_AHEAD, run(&MERGED)));
            steps.extend(run(&EXPANDED));
        }
    }
    if kind != Kind::Uniform {
        steps.extend(run(&CHECKED));
    }
    Schedule { steps }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::schedule::Cursor;
    use crate::tables::state::Population;

    /// The passes of a schedule: kernel, parameter and iteration.
    fn passes(schedule: &Schedule) -> Vec<(Kernel, u32, u32)> {
        let (mut cursor, counts) = (Cursor::start(), Population::default());
        std::iter::from_fn(|| {
            let ahead = cursor.guess(schedule, &counts, usize::MAX, |_| false);
            let kernel = cursor.next(schedule, &counts)?;
            assert_eq!(ahead.first().map(|call| (call.kernel, call.parameter)), Some((kernel, cursor.parameter)));
            Some((kernel, cursor.parameter, cursor.iteration))
        })
        .collect()
    }

    #[test]
    fn references_are_sorted_by_one_digit_after_the_other() {
        for cells in [1, 2, 17, 257, 5000, 1 << 20, 1 << 28] {
            let digits = digits_of(cells);
            let passes = passes(&of(Kind::Uniform, cells));
            let sorted = passes.iter().filter(|(kernel, ..)| kernel.info().name == "scatter");
            let sorted: Vec<_> = sorted.map(|&(kernel, digit, _)| (kernel, digit)).collect();
            let expected: Vec<_> =
                (0..digits).map(|digit| ([SCATTER_EVEN, SCATTER_ODD][digit as usize % 2], digit)).collect();
            assert_eq!(sorted, expected, "{cells} cells");
            let is_once = |kernel: &Kernel| passes.iter().filter(|(of, ..)| of == kernel).count() == 1;
            assert!(COUNTED.iter().chain(&STARTED).all(is_once));
        }
    }

    #[test]
    fn counted_loops_run_so_often_one_in_the_other_and_all_is_known_ahead() {
        let by = |kernel, first, by| Step::RunBy(kernel, Count { first, by });
        let inner = Step::Repeat("inner", Count::always(3), vec![by(FIND_BOUNDS, 10, &[2]), Step::Run(CHECK_BLOCKS)]);
        let never = Step::Repeat("never", Count::always(0), vec![Step::Run(FIND_HALVES)]);
        let steps = vec![
            by(SCAN_SPANS, 7, &[5]),
            Step::Repeat("outer", Count::always(2), vec![inner, never, by(ADD_SPANS, 0, &[1])]),
            Step::Run(TEST_SPANS),
        ];
        let schedule = Schedule { steps };
        let turn = |first| {
            let of = |turn: u32| [(FIND_BOUNDS, 10 + 2 * turn, turn + 1), (CHECK_BLOCKS, 1, turn + 1)];
            [of(0), of(1), of(2)].concat().into_iter().chain([(ADD_SPANS, first, first + 1)]).collect::<Vec<_>>()
        };
        let expected = [vec![(SCAN_SPANS, 7, 0)], turn(0), turn(1), vec![(TEST_SPANS, 0, 0)]].concat();
        assert_eq!(passes(&schedule), expected);
        let ahead = Cursor::start().guess(&schedule, &Population::default(), usize::MAX, |_| false);
        let ahead: Vec<_> = ahead.into_iter().map(|call| (call.kernel, call.parameter)).collect();
        assert_eq!(ahead, expected.iter().map(|&(kernel, parameter, _)| (kernel, parameter)).collect::<Vec<_>>());
        assert_eq!(schedule.passes_expected(), expected.len() as u64);
        // Nothing is known beyond the end of a loop whose condition is counted.
        let open = Schedule { steps: vec![Step::RepeatWhileAny(&LEFT, schedule.steps.clone())] };
        assert_eq!(Cursor::start().guess(&open, &Population::default(), usize::MAX, |_| false).len(), expected.len());
        let last = vec![Step::RepeatWhileAny(
            &LEFT,
            vec![Step::Repeat("last", Count::always(2), vec![Step::Run(FIND_BOUNDS)])],
        )];
        assert_eq!(
            Cursor::start().guess(&Schedule { steps: last }, &Population::default(), usize::MAX, |_| false).len(),
            2
        );
        assert!(!schedule.kernels().contains(&FIND_HALVES), "what never runs is not compiled");
    }
}
