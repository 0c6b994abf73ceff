//! The part of a ray's whole walk reached by a row of its history.

use std::collections::BTreeMap;

use crate::walk::{Outcome, Projected, Structure, WalkGeometry};

/// Progress of a walk.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Progress {
    /// The row; `None` before the first.
    pub(super) row: Option<usize>,
    /// The current visit.
    pub(super) visit: Option<usize>,
    /// The best outcome so far of each triangle in the picture; `None` if not tested yet.
    pub(super) outcomes: Vec<Option<Outcome>>,
}

impl Progress {
    pub(super) fn new(walk: &WalkGeometry, picture: &Projected, row: Option<usize>) -> Self {
        let mut best: BTreeMap<u32, Outcome> = BTreeMap::new();
        for tested in walk.tested.iter().filter(|tested| row.is_some_and(|row| tested.row <= row)) {
            let entry = best.entry(tested.triangle).or_insert(tested.outcome);
            *entry = tested.outcome.max(*entry);
        }
        let triangle = |test: usize| walk.tested.get(test).map(|tested| tested.triangle);
        let outcomes = picture
            .triangles
            .iter()
            .map(|t| triangle(t.test).and_then(|triangle| best.get(&triangle).copied()))
            .collect();
        let visit = (0..walk.cells.len().max(walk.nodes.len())).rev().find(|&visit| has_come(row, row_of(walk, visit)));
        Self { row, visit, outcomes }
    }

    /// Whether a row has been reached.
    pub(super) fn has(&self, row: usize) -> bool {
        has_come(self.row, Some(row))
    }
}

fn has_come(now: Option<usize>, row: Option<usize>) -> bool {
    now.zip(row).is_some_and(|(now, row)| row <= now)
}

/// The row in which a cell or node was visited.
pub(super) fn row_of(walk: &WalkGeometry, visit: usize) -> Option<usize> {
    match walk.structure {
        Structure::Grid => walk.cells.get(visit).map(|cell| cell.row),
        Structure::Tree => walk.nodes.get(visit).map(|node| node.row),
        Structure::Nothing => None,
    }
}

/// The target of a click on several visits: the first one, or the one after the current.
pub(super) fn chosen(visits: &[usize], current: Option<usize>) -> Option<usize> {
    let at = current.and_then(|current| visits.iter().position(|&visit| visit == current));
    at.map_or(visits.first(), |at| visits.get((at + 1) % visits.len())).copied()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Accelerator;

    use super::super::super::walked::tests::history;
    use super::*;

    #[test]
    fn tests_and_visits_after_the_current_row_are_not_shown_as_done() {
        for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
            let (history, data) = history(accelerator);
            let walk = WalkGeometry::new(&history, &data, usize::MAX);
            let picture = Projected::new(&walk);
            assert!(picture.triangles.len() > 1);
            let none = Progress::new(&walk, &picture, None);
            assert_eq!((none.visit, none.outcomes.iter().flatten().count()), (None, 0));
            let first = walk.tested[0];
            let early = Progress::new(&walk, &picture, Some(first.row));
            assert_eq!(early.visit, first.visit, "{accelerator:?}");
            assert_eq!(early.outcomes.iter().flatten().collect::<Vec<_>>(), [&first.outcome]);
            assert!(early.has(first.row) && !early.has(first.row + 1));
            let end = Progress::new(&walk, &picture, Some(history.rows.len()));
            let all: Vec<_> = picture.triangles.iter().map(|t| Some(t.outcome)).collect();
            assert_eq!(end.outcomes, all);
        }
    }

    #[test]
    fn clicks_go_through_the_cells_behind_each_other() {
        assert_eq!(chosen(&[3, 4, 5], None), Some(3));
        assert_eq!(chosen(&[3, 4, 5], Some(9)), Some(3));
        assert_eq!(chosen(&[3, 4, 5], Some(4)), Some(5));
        assert_eq!(chosen(&[3, 4, 5], Some(5)), Some(3));
        assert_eq!(chosen(&[], Some(5)), None);
    }
}
