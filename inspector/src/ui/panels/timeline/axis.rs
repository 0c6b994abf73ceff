//! The horizontal axis: which pass is where.

use raystep_kernels::Pass;
use raystep_kernels::tables::kernel::Role;
use serde::{Deserialize, Serialize};

/// What the width of a pass means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Scale {
    /// All passes have equal width.
    #[default]
    Passes,
    /// Width is proportional to time on the device.
    Time,
}

/// Whether a pass moves rays on their way to a hit.
pub(super) fn is_of_walk(pass: &Pass) -> bool {
    pass.kernel.is_walk() || pass.kernel.role() == Role::Whole
}

/// The passes that are shown, side by side.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Axis {
    /// Their indices in the run, in order.
    passes: Vec<usize>,
    /// The end of each, as a part of the axis.
    ends: Vec<f64>,
    /// The length of the axis: a number of passes, or nanoseconds.
    pub(super) total: f64,
}

impl Axis {
    pub(super) fn new(passes: &[Pass], scale: Scale, is_walk_only: bool) -> Self {
        let shown = passes.iter().enumerate().filter(|(_, pass)| !is_walk_only || is_of_walk(pass));
        let mut total = 0.0;
        let (passes, mut ends): (Vec<usize>, Vec<f64>) = shown
            .map(|(index, pass)| {
                total += match scale {
                    Scale::Passes => 1.0,
                    Scale::Time => pass.duration_ns.unwrap_or(0) as f64,
                };
                (index, total)
            })
            .unzip();
        ends.iter_mut().for_each(|end| *end = if total > 0.0 { *end / total } else { 1.0 });
        Self { passes, ends, total }
    }

    /// The number of passes shown.
    pub(super) fn len(&self) -> usize {
        self.passes.len()
    }

    /// The index in the run of a pass that is shown.
    pub(super) fn pass(&self, at: usize) -> Option<usize> {
        self.passes.get(at).copied()
    }

    /// Where the pass begins and ends.
    pub(super) fn span(&self, at: usize) -> [f64; 2] {
        let begin = at.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0.0);
        [begin, self.ends.get(at).copied().unwrap_or(1.0)]
    }

    /// The pass at a part of the axis, as an index among those that are shown.
    pub(super) fn at(&self, part: f64) -> usize {
        self.ends.partition_point(|&end| end < part).min(self.len().saturating_sub(1))
    }

    /// The place after the pass at a part of the axis; before the axis, the place before its first pass.
    pub(super) fn place_at(&self, part: f64) -> usize {
        let first = self.passes.first().copied().unwrap_or(0);
        if part < 0.0 { first } else { self.pass(self.at(part)).map_or(first, |pass| pass + 1) }
    }

    /// Where a place is: the end of the last pass before it that is shown.
    pub(super) fn part_of(&self, place: usize) -> f64 {
        let before = self.passes.partition_point(|&pass| pass < place);
        before.checked_sub(1).and_then(|last| self.ends.get(last)).copied().unwrap_or(0.0)
    }

    /// The middle of the pass that ends at a place, if it is shown.
    pub(super) fn middle_of(&self, place: usize) -> Option<f64> {
        let at = self.passes.binary_search(&place.checked_sub(1)?).ok()?;
        let [begin, end] = self.span(at);
        Some(0.5 * (begin + end))
    }

    /// The place so many shown passes further.
    pub(super) fn step(&self, place: usize, by: i64) -> usize {
        let before = self.passes.partition_point(|&pass| pass < place) as i64;
        let most = self.len() as i64;
        match usize::try_from(before.saturating_add(by).clamp(0, most)).unwrap_or(0).checked_sub(1) {
            Some(last) => self.passes.get(last).map_or(place, |pass| pass + 1),
            None => self.passes.first().copied().unwrap_or(place),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raystep_kernels::Kernel;
    use raystep_kernels::programs::closest_hit::kernels;

    fn pass(index: usize, kernel: Kernel, duration_ns: Option<u64>) -> Pass {
        Pass { index, rays_in: 1, threads_launched: 1, duration_ns, ..Pass::of(kernel) }
    }

    /// Two passes before the walk, four of it, one after it.
    fn passes() -> Vec<Pass> {
        let walk = [kernels::TRAVERSE_GRID, kernels::INTERSECT];
        let all = [kernels::GENERATE, kernels::SETUP].into_iter().chain(walk).chain(walk).chain([kernels::SHADE]);
        let ns = [40, 0, 10, 20, 10, 0, 20];
        all.zip(ns).enumerate().map(|(i, (kernel, ns))| pass(i, kernel, (ns > 0).then_some(ns))).collect()
    }

    #[test]
    fn every_scale_maps_to_the_pass_under_the_cursor_and_back() {
        for (scale, is_walk_only, places) in [
            (Scale::Passes, false, vec![1, 2, 3, 4, 5, 6, 7]),
            (Scale::Passes, true, vec![3, 4, 5, 6]),
            // Passes without a time have no width.
            (Scale::Time, false, vec![1, 3, 4, 5, 7]),
            (Scale::Time, true, vec![3, 4, 5]),
        ] {
            let axis = Axis::new(&passes(), scale, is_walk_only);
            let mut met: Vec<usize> = (0..=1000).map(|i| axis.place_at((f64::from(i) + 0.5) / 1001.0)).collect();
            met.dedup();
            assert_eq!(met, places, "{scale:?}, walk only: {is_walk_only}");
            for &place in &places {
                let middle = axis.middle_of(place).expect("it is shown");
                assert_eq!(axis.place_at(middle), place, "{scale:?}");
                assert!(axis.part_of(place) > middle);
            }
            assert_eq!((axis.part_of(0), axis.part_of(99)), (0.0, 1.0));
            assert_eq!(axis.place_at(-0.1), if is_walk_only { 2 } else { 0 });
            assert_eq!(axis.place_at(2.0), *axis.passes.last().expect("some") + 1);
        }
        assert_eq!(Axis::new(&passes(), Scale::Time, false).span(0), [0.0, 0.4]);
    }

    #[test]
    fn keys_go_from_one_shown_pass_to_the_next() {
        let axis = Axis::new(&passes(), Scale::Passes, false);
        assert_eq!(
            [(3, 1), (3, -1), (0, -1), (7, 1), (3, 10), (3, -10), (1, -1)].map(|(p, n)| axis.step(p, n)),
            [4, 2, 0, 7, 7, 0, 0]
        );
        let walk = Axis::new(&passes(), Scale::Passes, true);
        assert_eq!([(7, 0), (7, -1), (0, 1), (3, -1), (2, -1)].map(|(p, n)| walk.step(p, n)), [6, 5, 3, 2, 2]);
        let none = Axis::new(&[], Scale::Time, true);
        assert_eq!((none.step(5, 1), none.place_at(0.5), none.part_of(3), none.len()), (5, 0, 0.0, 0));
    }
}
