//! The loops of a schedule: what their turns are called, and which of them a pass is in.

use super::instance::Kernel;
use super::schedule::{Schedule, Step};
use crate::tables::kernel::Role;

impl Step {
    /// The steps that a loop repeats; `None` for a step that is no loop.
    #[must_use]
    pub fn body(&self) -> Option<&[Self]> {
        match self {
            Self::Run(_) | Self::RunBy(..) | Self::RunUntilIdle(_) => None,
            Self::LoopWhileActive(_, body) | Self::RepeatWhileAny(_, body) | Self::Repeat(_, _, body) => Some(body),
        }
    }

    /// What a turn of a loop is called.
    #[must_use]
    pub fn turn_name(&self) -> &'static str {
        match self {
            Self::Repeat(name, ..) => name,
            Self::LoopWhileActive(kernels, _) if kernels.iter().all(|kernel| kernel.role() == Role::Source) => "sample",
            _ => "iteration",
        }
    }

    /// Whether a turn of the loop may have several passes.
    fn is_of_several_passes(&self) -> bool {
        !matches!(self.body(), None | Some([Self::Run(_) | Self::RunBy(..)]))
    }
}

impl Schedule {
    /// Whether it has loops that run a certain number of times.
    #[must_use]
    pub fn has_counted_loops(&self) -> bool {
        fn any(steps: &[Step]) -> bool {
            steps.iter().any(|step| matches!(step, Step::Repeat(..)) || step.body().is_some_and(any))
        }
        any(&self.steps)
    }

    /// The loops, outermost first, that a pass of a kernel is in if it is in so many; the first such loops, if a schedule
    /// runs the kernel in several; none, if in no such loops.
    #[must_use]
    pub fn loops_around(&self, kernel: Kernel, depth: usize) -> Vec<&Step> {
        fn find<'a>(steps: &'a [Step], kernel: Kernel, depth: usize, around: &mut Vec<&'a Step>) -> bool {
            steps.iter().any(|step| match step {
                Step::Run(run) | Step::RunBy(run, _) | Step::RunUntilIdle(run) => {
                    *run == kernel && around.len() == depth
                }
                looped => {
                    around.push(looped);
                    let is_found = find(looped.body().unwrap_or_default(), kernel, depth, around);
                    if !is_found {
                        around.pop();
                    }
                    is_found
                }
            })
        }
        let mut around = Vec::new();
        find(&self.steps, kernel, depth, &mut around);
        around
    }

    /// Of the turns that a pass of a kernel is in, outermost first: those down to the innermost loop whose turns may have
    /// several passes.
    #[must_use]
    pub fn turns_of_several_passes<'a>(&self, kernel: Kernel, turns: &'a [u32]) -> &'a [u32] {
        let around = self.loops_around(kernel, turns.len());
        let innermost = around.iter().rposition(|of| of.is_of_several_passes());
        turns.get(..innermost.map_or(0, |at| at + 1)).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::ScheduleKind;
    use crate::options::features::Features;
    use crate::programs::closest_hit::kernels::{ACCUMULATE, INTERSECT, SHADE, TRAVERSE_GRID};
    use crate::programs::{closest_hit, sort};

    #[test]
    fn turns_are_named_by_what_a_schedule_repeats() {
        let walk = closest_hit::schedule::new(
            ScheduleKind::First,
            &Features { grid: true, ..Features::default() },
            false,
            true,
        );
        let samples = closest_hit::schedule::for_samples(walk.clone());
        let sort = sort::schedule(64);
        for (schedule, kernel, depth, names) in [
            (&walk, SHADE, 0, ""),
            (&walk, INTERSECT, 1, "iteration"),
            (&samples, TRAVERSE_GRID, 2, "sample, iteration"),
            (&samples, ACCUMULATE, 1, "sample"),
            (&samples, ACCUMULATE, 2, ""),
            (&sort, sort::EXCHANGE, 2, "stage, step"),
        ] {
            let around = schedule.loops_around(kernel, depth);
            let found: Vec<_> = around.into_iter().map(Step::turn_name).collect();
            assert_eq!(found.join(", "), names, "{kernel:?} in {depth} loops");
        }
        assert_eq!([&walk, &samples, &sort].map(|schedule| schedule.has_counted_loops()), [false, false, true]);
    }

    #[test]
    fn a_loop_that_repeats_one_pass_is_no_turn_of_several() {
        let walk = closest_hit::schedule::new(
            ScheduleKind::First,
            &Features { grid: true, ..Features::default() },
            false,
            true,
        );
        let samples = closest_hit::schedule::for_samples(walk);
        assert_eq!(samples.turns_of_several_passes(INTERSECT, &[2, 7]), [2, 7]);
        assert_eq!(samples.turns_of_several_passes(SHADE, &[2]), [2]);
        assert_eq!(sort::schedule(64).turns_of_several_passes(sort::EXCHANGE, &[4, 3]), [4], "a step is one pass");
        assert!(sort::schedule(64).turns_of_several_passes(sort::EXCHANGE, &[]).is_empty());
    }
}
