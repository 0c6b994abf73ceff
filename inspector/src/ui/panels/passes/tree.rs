//! The passes as a tree, by the turns of the schedule's loops. Only passes that were added are looked at, and the rows
//! that are shown are found anew only when others are.

use std::collections::BTreeMap;

use raystep_kernels::Pass;
use raystep_kernels::program::schedule::Schedule;

use crate::ui::panels::turns::{Turn, Turns};

/// Levels are folded, the innermost first, until at most so many rows are shown.
const MOST_ROWS: usize = 200;

/// A row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Node {
    /// Before the first pass.
    Start,
    /// A turn of a loop of this level, by its first pass.
    Turn(usize, usize),
    /// A pass.
    Pass(usize),
}

/// How long the passes of a turn took together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Time {
    Known(u64),
    /// Some were too short to tell.
    Below(u64),
    /// Some were not timed.
    Unknown,
}

/// Sums over the first passes: of durations, of these and the bounds of passes that were too short to tell, and the
/// numbers of such passes and of those that were not timed.
type Sums = [u64; 4];

/// The tree. Without loops of several turns it is a list.
#[derive(Default)]
pub(super) struct Tree {
    /// Generation and edition of the run, and its number of passes.
    of: ([u64; 2], usize),
    turns: Turns,
    /// Rows and their depths, each after those that it is in.
    nodes: Vec<(Node, usize)>,
    /// The row of each pass.
    of_pass: Vec<usize>,
    /// The number of rows of each depth.
    depths: Vec<usize>,
    /// Before each pass, and after the last one.
    sums: Vec<Sums>,
    /// Turns that the user has folded or unfolded: by level and first pass.
    chosen: BTreeMap<(usize, usize), bool>,
    /// The turns with rows that the current pass is in, outermost first.
    current: Vec<Option<Turn>>,
    unfolded: Vec<usize>,
    version: u64,
}

impl Tree {
    /// Takes in what has changed: the passes of a run, or the place.
    pub(super) fn update(&mut self, run: [u64; 2], passes: &[Pass], schedule: &Schedule, place: usize) {
        let of = (run, passes.len());
        let mut is_changed = self.of != of || self.nodes.is_empty();
        if is_changed {
            if self.of.0 != run || self.of.1 > passes.len() {
                let is_same_run = self.of.0[0] == run[0];
                let chosen = if is_same_run { std::mem::take(&mut self.chosen) } else { BTreeMap::new() };
                *self = Self { chosen, version: self.version, ..Self::default() };
            }
            let was_list = self.is_list();
            self.turns.extend(passes);
            if was_list != self.is_list() {
                self.nodes.clear();
                self.of_pass.clear();
                self.depths.clear();
            }
            self.add(passes, schedule);
            self.sum(passes);
            self.of = of;
        }
        let (_, around) = self.node(self.row_at(place));
        let current = (0..around).map(|level| self.turns.of(level, place.checked_sub(1)?)).collect();
        if self.current != current {
            self.current = current;
            is_changed = true;
        }
        if is_changed {
            self.unfold();
        }
    }

    fn add(&mut self, passes: &[Pass], schedule: &Schedule) {
        let is_new = self.nodes.is_empty();
        let mut add = |node, depth: usize| {
            self.depths.resize(self.depths.len().max(depth + 1), 0);
            self.depths[depth] += 1;
            self.nodes.push((node, depth));
            self.nodes.len() - 1
        };
        if is_new {
            add(Node::Start, 0);
        }
        let levels = self.turns.levels().len();
        for (index, pass) in passes.iter().enumerate().skip(self.of_pass.len()) {
            // A turn that is one pass needs no row beside that pass's.
            let around = schedule.turns_of_several_passes(pass.kernel, &pass.loops).len().min(levels);
            for level in 0..around {
                if self.turns.of(level, index).is_some_and(|turn| turn[0] == index) {
                    add(Node::Turn(level, index), level);
                }
            }
            self.of_pass.push(add(Node::Pass(index), around));
        }
    }

    /// All anew: passes that run again may take another time.
    fn sum(&mut self, passes: &[Pass]) {
        let mut sum: Sums = [0; 4];
        self.sums.clear();
        self.sums.push(sum);
        for pass in passes {
            let part = match (pass.duration_ns, pass.below_ns()) {
                (Some(ns), _) => [ns, ns, 0, 0],
                (None, Some(below)) => [0, below, 1, 0],
                (None, None) => [0, 0, 0, 1],
            };
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum = sum.saturating_add(part));
            self.sums.push(sum);
        }
    }

    /// Finds the rows that are shown.
    fn unfold(&mut self) {
        let mut unfolded = std::mem::take(&mut self.unfolded);
        unfolded.clear();
        // The depth of the folded turn that rows are in.
        let mut folded: Option<usize> = None;
        for (row, &(_, depth)) in self.nodes.iter().enumerate() {
            if folded.is_some_and(|folded| depth > folded) {
                continue;
            }
            unfolded.push(row);
            folded = self.is_open(row).is_some_and(|is_open| !is_open).then_some(depth);
        }
        self.unfolded = unfolded;
        self.version += 1;
    }

    /// Levels that are unfolded unless the user has chosen: as many as show few rows.
    fn levels_open(&self) -> usize {
        let shown = self.depths.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        });
        shown.take_while(|&rows| rows <= MOST_ROWS).count().saturating_sub(1)
    }

    /// Whether what is below a row is shown; `None` if that is nothing.
    pub(super) fn is_open(&self, row: usize) -> Option<bool> {
        let (Node::Turn(level, first), _) = *self.nodes.get(row)? else { return None };
        let chosen = || self.chosen.get(&(level, first)).copied().unwrap_or(level < self.levels_open());
        Some(self.is_current(row) || chosen())
    }

    /// Whether a row is a turn with the current pass in it, which is always unfolded.
    pub(super) fn is_current(&self, row: usize) -> bool {
        let Some((Node::Turn(level, first), _)) = self.nodes.get(row) else { return false };
        self.current.get(*level).copied().flatten().is_some_and(|turn| turn[0] == *first)
    }

    /// Folds or unfolds a turn.
    pub(super) fn toggle(&mut self, row: usize) {
        if let Some((Node::Turn(level, first), _)) = self.nodes.get(row).copied()
            && let Some(is_open) = self.is_open(row)
        {
            self.chosen.insert((level, first), !is_open);
            self.unfold();
        }
    }

    /// Whether there are no turns to tell apart.
    pub(super) fn is_list(&self) -> bool {
        self.turns.levels().is_empty()
    }

    /// The number of rows, folded ones too.
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// A row, and its depth.
    pub(super) fn node(&self, row: usize) -> (Node, usize) {
        self.nodes.get(row).copied().unwrap_or((Node::Start, 0))
    }

    /// The row of the pass before a place.
    pub(super) fn row_at(&self, place: usize) -> usize {
        place.min(self.of_pass.len()).checked_sub(1).map_or(0, |pass| self.of_pass[pass])
    }

    /// The rows that are shown, and their version.
    pub(super) fn unfolded(&self) -> (u64, &[usize]) {
        (self.version, &self.unfolded)
    }

    /// The passes of a turn.
    pub(super) fn turn(&self, level: usize, first: usize) -> Turn {
        self.turns.of(level, first).unwrap_or([first, first + 1])
    }

    /// How long they took.
    pub(super) fn time(&self, [first, end]: Turn) -> Time {
        let [Some(before), Some(after)] = [first, end].map(|at| self.sums.get(at)) else { return Time::Unknown };
        match [0, 1, 2, 3].map(|i| after[i].saturating_sub(before[i])) {
            [ns, _, 0, 0] => Time::Known(ns),
            [_, below, _, 0] => Time::Below(below),
            _ => Time::Unknown,
        }
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::program::schedule::Cursor;
    use raystep_kernels::programs::{grid_build, sort};
    use raystep_kernels::tables::state::Population;

    use super::*;

    /// The passes of a schedule whose loops are all counted.
    fn counted(schedule: &Schedule) -> Vec<Pass> {
        let (mut cursor, counts) = (Cursor::start(), Population::default());
        let next = |index| {
            let kernel = cursor.next(schedule, &counts)?;
            Some(Pass { index, loops: cursor.loops(), duration_ns: Some(1 << index.min(9)), ..Pass::of(kernel) })
        };
        (0..).map_while(next).collect()
    }

    fn tree(passes: &[Pass], schedule: &Schedule, place: usize) -> Tree {
        let mut tree = Tree::default();
        tree.update([1, 1], passes, schedule, place);
        tree
    }

    /// Rows as shown: depth, `s`tart, turn or pass, and the passes.
    fn shown(tree: &Tree) -> Vec<(usize, char, usize, usize)> {
        let row = |&row: &usize| match tree.node(row) {
            (Node::Start, depth) => (depth, 's', 0, 0),
            (Node::Turn(level, first), depth) => {
                let [first, end] = tree.turn(level, first);
                (depth, 't', first, end)
            }
            (Node::Pass(pass), depth) => (depth, 'p', pass, pass + 1),
        };
        tree.unfolded().1.iter().map(row).collect()
    }

    #[test]
    fn a_sort_is_grouped_by_stages_whose_steps_are_single_passes() {
        let schedule = sort::schedule(8);
        let passes = counted(&schedule);
        let tree = tree(&passes, &schedule, 0);
        let expected = [
            (0, 's', 0, 0),
            (0, 't', 0, 1),
            (1, 'p', 0, 1),
            (0, 't', 1, 3),
            (1, 'p', 1, 2),
            (1, 'p', 2, 3),
            (0, 't', 3, 6),
            (1, 'p', 3, 4),
            (1, 'p', 4, 5),
            (1, 'p', 5, 6),
        ];
        assert_eq!(shown(&tree), expected);
        assert_eq!([[0, 1], [1, 3], [3, 6]].map(|turn| tree.time(turn)), [1, 6, 56].map(Time::Known));
    }

    #[test]
    fn samples_have_their_iterations_and_passes_outside_of_loops_stay_outside() {
        use raystep_kernels::options::ScheduleKind;
        use raystep_kernels::options::features::Features;
        use raystep_kernels::programs::closest_hit::kernels::{ACCUMULATE, GENERATE, INTERSECT, TRAVERSE_GRID};
        use raystep_kernels::programs::closest_hit::schedule;
        let walk = schedule::new(ScheduleKind::First, &Features { grid: true, ..Features::default() }, false, true);
        let schedule = schedule::for_samples(walk.clone());
        let pass =
            |(index, (kernel, loops)): (usize, (_, &[u32]))| Pass { index, loops: loops.to_vec(), ..Pass::of(kernel) };
        let of_sample = |sample: u32| {
            let turns = [0, 0, 1, 1].map(|turn| vec![sample, turn]);
            let inner = [TRAVERSE_GRID, INTERSECT].into_iter().cycle().zip(turns);
            [(GENERATE, vec![sample])].into_iter().chain(inner).chain([(ACCUMULATE, vec![sample])])
        };
        let all: Vec<_> = (0..2).flat_map(of_sample).collect();
        let passes: Vec<Pass> = all.iter().map(|(kernel, loops)| (*kernel, &loops[..])).enumerate().map(pass).collect();
        let mut tree = tree(&passes, &schedule, 0);
        let of = |first| {
            [
                (0, 't', first, first + 6),
                (1, 'p', first, first + 1),
                (1, 't', first + 1, first + 3),
                (2, 'p', first + 1, first + 2),
                (2, 'p', first + 2, first + 3),
                (1, 't', first + 3, first + 5),
                (2, 'p', first + 3, first + 4),
                (2, 'p', first + 4, first + 5),
                (1, 'p', first + 5, first + 6),
            ]
        };
        let expected: Vec<_> = [(0, 's', 0, 0)].into_iter().chain(of(0)).chain(of(6)).collect();
        assert_eq!(shown(&tree), expected);
        assert_eq!(tree.time([0, 6]), Time::Unknown);
        // The second sample is folded, until the run gets there; then it is folded again.
        let second = tree.row_at(7) - 1;
        tree.toggle(second);
        assert_eq!(shown(&tree), expected[..11]);
        for (place, rows) in [(3, 11), (7, 19), (6, 11)] {
            tree.update([1, 1], &passes, &schedule, place);
            assert_eq!(shown(&tree).len(), rows, "at {place}");
            assert_eq!(tree.is_current(second), place == 7);
        }
    }

    #[test]
    fn a_build_is_a_list_until_a_loop_turns_and_its_passes_may_come_one_by_one() {
        use grid_build::schedule::{Kind, of};
        for (cells, turns) in [(200, 1), (5000, 2), (1 << 28, 3)] {
            let schedule = of(Kind::Uniform, cells);
            let passes = counted(&schedule);
            let pairs = passes.iter().filter_map(|pass| pass.loops.first()).max().map_or(0, |last| last + 1);
            assert_eq!(pairs, turns);
            let whole = tree(&passes, &schedule, 0);
            assert_eq!(whole.is_list(), pairs < 2, "{pairs} turns");
            let turns = shown(&whole).iter().filter(|row| row.1 == 't').count();
            assert_eq!(turns, if pairs < 2 { 0 } else { pairs as usize });
            let mut grown = Tree::default();
            for place in 0..=passes.len() {
                grown.update([1, 1], &passes[..place], &schedule, place);
                assert_eq!(grown.row_at(place), grown.len() - 1);
            }
            assert_eq!(shown(&grown), shown(&whole));
        }
    }

    #[test]
    fn of_many_passes_only_the_current_turn_is_unfolded_and_nothing_is_found_anew_without_a_change() {
        let schedule = sort::schedule(1 << 20);
        let passes = counted(&schedule);
        assert_eq!(passes.len(), 210);
        let mut tree = tree(&passes, &schedule, 4);
        let rows = shown(&tree);
        // The start, 20 stages, and the three steps of the third stage.
        assert_eq!(rows.len(), 1 + 20 + 3);
        assert_eq!(rows[3..7].iter().map(|row| row.1).collect::<String>(), "tppp");
        let version = tree.unfolded().0;
        tree.update([1, 1], &passes, &schedule, 4);
        tree.update([1, 1], &passes, &schedule, 6);
        assert_eq!(tree.unfolded().0, version, "the same turn");
        tree.update([1, 1], &passes, &schedule, 7);
        assert_ne!(tree.unfolded().0, version);
        // What is folded by hand is so in another edition, but not in another run.
        let last = tree.row_at(210) - 20;
        assert_eq!(tree.is_open(last), Some(false));
        tree.toggle(last);
        for (run, is_open) in [([1, 2], true), ([2, 3], false)] {
            tree.update(run, &passes, &schedule, 7);
            assert_eq!(tree.is_open(last), Some(is_open));
        }
    }

    #[test]
    fn the_time_of_a_turn_is_as_well_known_as_that_of_its_passes() {
        use raystep_kernels::Rounding;
        let schedule = sort::schedule(8);
        let mut passes = counted(&schedule);
        passes[1].duration_ns = None;
        passes[4].duration_ns = None;
        passes[4].rounding = Some(Rounding { runs: 3, error_ns: 10, below_ns: 100 });
        let tree = tree(&passes, &schedule, 0);
        let times = [[0, 1], [1, 3], [3, 6]].map(|turn| tree.time(turn));
        assert_eq!(times, [Time::Known(1), Time::Unknown, Time::Below(8 + 100 + 32)]);
        let empty = Tree::default();
        assert_eq!((empty.row_at(3), empty.time([0, 1])), (0, Time::Unknown));
    }
}
