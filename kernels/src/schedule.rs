//! Which kernels run, in what order, until what holds: a value that can be checked without a GPU.

use crate::kernel::Kernel;
use crate::options::{Accelerator, ScheduleKind};
use crate::state::{self, StateCounts};

/// One line of a schedule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Run a kernel once.
    Run(Kernel),
    /// Run a kernel until no ray is active there; not at all if none is.
    RunUntilIdle(Kernel),
    /// Run the steps again and again while any ray is active in one of the kernels.
    LoopWhileActive(&'static [Kernel], Vec<Step>),
}

impl Step {
    /// Whether it is the walk: the steps that move rays until their hits are found.
    fn is_walk(&self) -> bool {
        match self {
            Self::Run(_) => false,
            Self::RunUntilIdle(kernel) => kernel.is_walk(),
            Self::LoopWhileActive(kernels, _) => kernels.iter().all(|k| k.is_walk()),
        }
    }
}

/// An order of kernels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// The steps, first to last.
    pub steps: Vec<Step>,
}

impl Schedule {
    /// The paper's §4.3, and ours. `rays_given`: there is nothing to generate; `shade`: the image is wanted;
    /// `eye_rays`: the fused kernel makes its rays itself; `many_steps`: a ray takes several steps a pass.
    #[must_use]
    pub fn new(
        kind: ScheduleKind,
        accelerator: Accelerator,
        rays_given: bool,
        shade: bool,
        eye_rays: bool,
        many_steps: bool,
    ) -> Self {
        use Kernel::{Fused, Generate, Intersect, Setup, Shade, TraverseBvh, TraverseGrid, Walk};
        let mut steps = Vec::new();
        if !rays_given && !eye_rays {
            steps.push(Step::Run(Generate));
        }
        if kind == ScheduleKind::Fused {
            steps.push(Step::Run(Fused));
        } else {
            let is_first = kind == ScheduleKind::First;
            let walk = match accelerator {
                _ if many_steps => Step::RunUntilIdle(Walk),
                // The printed condition of the first strategy is inverted; `while (!done || traverser())` is meant.
                Accelerator::Grid | Accelerator::Auto if is_first => Step::LoopWhileActive(
                    &[Intersect, TraverseGrid],
                    vec![Step::RunUntilIdle(Intersect), Step::Run(TraverseGrid)],
                ),
                Accelerator::Grid | Accelerator::Auto => Step::LoopWhileActive(
                    &[Intersect, TraverseGrid],
                    vec![Step::Run(Intersect), Step::Run(TraverseGrid)],
                ),
                // A tree's root has no triangles: its walk begins with a step.
                Accelerator::Bvh if is_first => Step::LoopWhileActive(
                    &[Intersect, TraverseBvh],
                    vec![Step::Run(TraverseBvh), Step::RunUntilIdle(Intersect)],
                ),
                Accelerator::Bvh => {
                    Step::LoopWhileActive(&[Intersect, TraverseBvh], vec![Step::Run(TraverseBvh), Step::Run(Intersect)])
                }
                Accelerator::None => Step::RunUntilIdle(Intersect),
            };
            steps.extend([Step::Run(Setup), walk]);
        }
        if shade {
            steps.push(Step::Run(Shade));
        }
        Self { steps }
    }

    /// The same for several samples a pixel: all steps again and again, as long as a pixel asks for another sample.
    #[must_use]
    pub fn for_samples(self) -> Self {
        let mut body = self.steps;
        body.push(Step::Run(Kernel::Accumulate));
        Self { steps: vec![Step::LoopWhileActive(&[Kernel::Generate], body)] }
    }

    /// Every kernel that the schedule can run, in order of first use.
    #[must_use]
    pub fn kernels(&self) -> Vec<Kernel> {
        fn collect(steps: &[Step], kernels: &mut Vec<Kernel>) {
            for step in steps {
                match step {
                    Step::Run(k) | Step::RunUntilIdle(k) => {
                        if !kernels.contains(k) {
                            kernels.push(*k);
                        }
                    }
                    Step::LoopWhileActive(_, body) => collect(body, kernels),
                }
            }
        }
        let mut kernels = Vec::new();
        collect(&self.steps, &mut kernels);
        kernels
    }
}

impl Schedule {
    /// Whether it goes through its steps once a sample.
    fn has_samples(&self) -> bool {
        matches!(self.steps[..], [Step::LoopWhileActive([Kernel::Generate], _)])
    }

    /// The counts after a kernel that is no part of the walk, if it sent all of its rays on to the next kernel.
    fn after_all(&self, kernel: Kernel, counts: &StateCounts) -> StateCounts {
        let walk = || self.kernels().into_iter().find(|k| k.is_walk()).and_then(|k| k.info().active.first().copied());
        let to = match kernel {
            Kernel::Setup => walk(),
            Kernel::Accumulate => Some(state::UNWRITTEN),
            _ => kernel.sends_all_to(),
        };
        let mut after = *counts;
        if let Some(to) = to {
            kernel.info().active.iter().for_each(|&tag| after[tag as usize] = 0);
            after[to as usize] += kernel.live(counts);
        }
        after
    }
}

/// A place in a schedule. Cloning it and walking the clone on a guess tells which passes may come next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cursor {
    /// Index of the step at each depth of nesting, outermost first.
    path: Vec<usize>,
    /// How often the body of the walk's loop was begun, of several samples a pixel in this sample.
    pub iteration: u32,
    /// Samples of every pixel that are complete; 0 where a pixel has one.
    pub samples: u32,
}

impl Cursor {
    /// Before the first step.
    #[must_use]
    pub fn start() -> Self {
        Self { path: vec![0], iteration: 0, samples: 0 }
    }

    /// The kernel that runs next, given how many rays are in each state; `None` at the end. Moves past it.
    pub fn next(&mut self, schedule: &Schedule, counts: &StateCounts) -> Option<Kernel> {
        loop {
            let (steps, parent) = self.steps(schedule);
            let index = *self.path.last()?;
            let Some(step) = steps.get(index) else {
                // End of a body: back to the loop's head, or the end of the schedule.
                parent?;
                self.path.pop();
                continue;
            };
            match step {
                Step::Run(kernel) => {
                    match kernel {
                        Kernel::Generate => self.iteration = 0,
                        Kernel::Accumulate => self.samples += 1,
                        _ => {}
                    }
                    *self.path.last_mut()? += 1;
                    return Some(*kernel);
                }
                Step::RunUntilIdle(kernel) => {
                    if kernel.live(counts) > 0 {
                        return Some(*kernel);
                    }
                    *self.path.last_mut()? += 1;
                }
                Step::LoopWhileActive(kernels, _) => {
                    if kernels.iter().any(|k| k.live(counts) > 0) {
                        self.iteration += u32::from(step.is_walk());
                        self.path.push(0);
                    } else {
                        *self.path.last_mut()? += 1;
                    }
                }
            }
        }
    }

    /// Goes on behind the walk, whatever is still active in it; stays where it is outside of the walk.
    pub fn leave_walk(&mut self, schedule: &Schedule) {
        if let Some(depth) = self.walk_depth(schedule) {
            self.path.truncate(depth + 1);
            self.path[depth] += 1;
        }
    }

    /// The next passes if every ray stayed where it is: what may be submitted before the counts of the
    /// first are known. A pass on which no ray is active changes nothing, so a wrong guess is harmless as
    /// long as it only repeats kernels that have become idle.
    ///
    /// Of several samples a pixel, also the steps from the end of a walk into the next sample's, as if there were one
    /// and every ray began to walk: where not, they find no ray either. So a sample costs about one submission.
    #[must_use]
    pub fn guess(&self, schedule: &Schedule, counts: &StateCounts, most: usize) -> Vec<Kernel> {
        let mut cursor = self.clone();
        let Some(first) = cursor.next(schedule, counts) else { return Vec::new() };
        let mut kernels = vec![first];
        let mut counts = *counts;
        let mut last = first;
        while schedule.has_samples() && !last.is_walk() {
            counts = schedule.after_all(last, &counts);
            match cursor.next(schedule, &counts) {
                // The fused kernel is submitted alone: in parts, and what it did is counted anew.
                Some(next) if kernels.len() < most && ![last, next].contains(&Kernel::Fused) => {
                    kernels.push(next);
                    last = next;
                }
                _ => return kernels,
            }
        }
        // Only inside of a loop may a pass be repeated for nothing.
        if !cursor.in_walk(schedule) {
            return kernels;
        }
        while kernels.len() < most.max(1) {
            let mut ahead = cursor.clone();
            match ahead.next(schedule, &counts) {
                // A kernel that runs once a turn is idle right after; guessing it again would be for nothing.
                Some(kernel)
                    if ahead.in_walk(schedule)
                        && (kernels.last() != Some(&kernel) || ahead.stays(schedule, kernel)) =>
                {
                    kernels.push(kernel);
                }
                _ => break,
            }
            cursor = ahead;
        }
        kernels
    }

    /// Whether the step that the cursor is at may run the kernel, which ran just now, again at once.
    fn stays(&self, schedule: &Schedule, kernel: Kernel) -> bool {
        let index = self.path.last().copied().unwrap_or(0);
        matches!(self.steps(schedule).0.get(index), Some(Step::RunUntilIdle(again)) if *again == kernel)
    }

    fn in_walk(&self, schedule: &Schedule) -> bool {
        self.walk_depth(schedule).is_some()
    }

    /// At which depth of nesting the walk is that the cursor is in, or right before.
    fn walk_depth(&self, schedule: &Schedule) -> Option<usize> {
        let mut steps = schedule.steps.as_slice();
        for (depth, &index) in self.path.iter().enumerate() {
            match steps.get(index)? {
                step if step.is_walk() => return Some(depth),
                Step::LoopWhileActive(_, body) => steps = body,
                _ => return None,
            }
        }
        None
    }

    /// The steps at the innermost depth, and the loop that they are the body of.
    fn steps<'a>(&self, schedule: &'a Schedule) -> (&'a [Step], Option<&'a Step>) {
        let (mut steps, mut parent) = (schedule.steps.as_slice(), None);
        for &index in &self.path[..self.path.len() - 1] {
            let Step::LoopWhileActive(_, body) = &steps[index] else { break };
            (steps, parent) = (body, Some(&steps[index]));
        }
        (steps, parent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{DONE, ISECT_NO_HIT, SHADE, TRAV};

    fn counts(isect: u32, trav: u32, shade: u32) -> StateCounts {
        let mut c = StateCounts::default();
        (c[ISECT_NO_HIT as usize], c[TRAV as usize], c[SHADE as usize]) = (isect, trav, shade);
        c
    }

    fn run(kind: ScheduleKind, accelerator: Accelerator, script: &[StateCounts]) -> Vec<&'static str> {
        let schedule = Schedule::new(kind, accelerator, false, true, false, false);
        let mut cursor = Cursor::start();
        let mut now = counts(0, 0, 0);
        let mut names = Vec::new();
        for after in script {
            names.push(cursor.next(&schedule, &now).map_or("end", Kernel::name));
            now = *after;
        }
        names.push(cursor.next(&schedule, &now).map_or("end", Kernel::name));
        names
    }

    #[test]
    fn second_takes_turns_until_both_are_idle() {
        let (c, mut done) = (counts, StateCounts::default());
        done[DONE as usize] = 9;
        let script = [c(0, 0, 0), c(9, 0, 0), c(4, 5, 0), c(9, 0, 0), c(0, 4, 5), c(0, 0, 9), done];
        let names = run(ScheduleKind::Second, Accelerator::Grid, &script);
        let expected =
            ["generate", "setup", "intersect", "traverse_grid", "intersect", "traverse_grid", "shade", "end"];
        assert_eq!(names, expected);
    }

    #[test]
    fn first_empties_intersect_before_it_traverses() {
        let c = counts;
        let script = [c(0, 0, 0), c(9, 0, 0), c(4, 5, 0), c(0, 9, 0), c(2, 0, 7), c(0, 0, 9), c(0, 0, 9), c(0, 0, 0)];
        let names = run(ScheduleKind::First, Accelerator::Grid, &script);
        let expected = [
            "generate",
            "setup",
            "intersect",
            "intersect",
            "traverse_grid",
            "intersect",
            "traverse_grid",
            "shade",
            "end",
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn without_a_grid_there_is_nothing_to_traverse() {
        let c = counts;
        let script = [c(0, 0, 0), c(9, 0, 0), c(3, 0, 6), c(0, 0, 9), c(0, 0, 0)];
        let names = run(ScheduleKind::Second, Accelerator::None, &script);
        assert_eq!(names, ["generate", "setup", "intersect", "intersect", "shade", "end"]);
    }

    fn sampled(kind: ScheduleKind, accelerator: Accelerator, many_steps: bool) -> Schedule {
        Schedule::new(kind, accelerator, false, true, false, many_steps).for_samples()
    }

    #[test]
    fn all_steps_come_again_as_long_as_a_pixel_wants_a_sample() {
        let schedule = sampled(ScheduleKind::Second, Accelerator::Grid, false);
        let (c, all) = (counts, |tag: u32| std::array::from_fn(|i| if i == tag as usize { 9 } else { 0 }));
        let (unwritten, done) = (all(0), all(DONE));
        let mut cursor = Cursor::start();
        let once = [unwritten, c(0, 0, 0), c(9, 0, 0), c(0, 9, 0), c(0, 0, 9), done];
        let names = ["generate", "setup", "intersect", "traverse_grid", "shade", "accumulate"];
        for turn in 0..3 {
            for ((now, name), iteration) in once.iter().zip(names).zip([0, 0, 1, 1, 1, 1]) {
                assert_eq!(cursor.next(&schedule, now).map(Kernel::name), Some(name), "sample {turn}");
                assert_eq!(cursor.iteration, iteration, "{name}");
                assert_eq!(cursor.samples, turn + u32::from(name == "accumulate"));
            }
        }
        assert_eq!(cursor.next(&schedule, &done), None);
        assert_eq!(cursor.samples, 3);
    }

    #[test]
    fn a_walk_that_is_left_goes_on_with_its_own_sample() {
        for (kind, accelerator, many_steps) in [
            (ScheduleKind::Second, Accelerator::Grid, false),
            (ScheduleKind::First, Accelerator::Grid, false),
            (ScheduleKind::First, Accelerator::Bvh, false),
            (ScheduleKind::Compact, Accelerator::Grid, true),
            (ScheduleKind::Second, Accelerator::None, false),
        ] {
            for schedule in [
                Schedule::new(kind, accelerator, false, true, false, many_steps),
                sampled(kind, accelerator, many_steps),
            ] {
                let mut cursor = Cursor::start();
                let mut unwritten = counts(5, 5, 0);
                unwritten[state::UNWRITTEN as usize] = 1;
                while !cursor.next(&schedule, &unwritten).expect("a walk").is_walk() {
                    let mut outside = cursor.clone();
                    outside.leave_walk(&schedule);
                    assert!(outside == cursor || outside.next(&schedule, &unwritten) == Some(Kernel::Shade));
                }
                cursor.next(&schedule, &unwritten);
                cursor.leave_walk(&schedule);
                assert_eq!(cursor.next(&schedule, &unwritten), Some(Kernel::Shade), "{kind} {accelerator}");
                let again = cursor.clone();
                cursor.leave_walk(&schedule);
                assert_eq!(cursor, again, "there is nothing to leave");
            }
        }
    }

    #[test]
    fn a_guess_goes_on_to_the_next_sample_and_no_farther_than_its_walk() {
        use Kernel::{Accumulate, Generate, Intersect, Setup, Shade, TraverseBvh, Walk};
        let guesses = |schedule: &Schedule, most: usize| {
            let mut cursor = Cursor::start();
            let mut unwritten = StateCounts::default();
            unwritten[state::UNWRITTEN as usize] = 9;
            let first = cursor.guess(schedule, &unwritten, most);
            while cursor.next(schedule, &unwritten) != Some(Shade) {}
            // Right before it, as far as counts go.
            let mut before = Cursor { path: cursor.path.clone(), ..cursor };
            if let Some(last) = before.path.last_mut() {
                *last -= 1;
            }
            (first, before.guess(schedule, &counts(0, 0, 9), most))
        };
        let compact = sampled(ScheduleKind::Compact, Accelerator::Grid, true);
        let (first, next) = guesses(&compact, 7);
        assert_eq!(first, [Generate, Setup, Walk, Walk, Walk, Walk, Walk]);
        assert_eq!(next, [Shade, Accumulate, Generate, Setup, Walk, Walk, Walk]);
        assert_eq!(guesses(&compact, 3).1, [Shade, Accumulate, Generate]);
        let (first, next) = guesses(&sampled(ScheduleKind::Fused, Accelerator::Grid, false), 8);
        assert_eq!((first, next), (vec![Generate], vec![Shade, Accumulate, Generate]));
        let (first, _) = guesses(&sampled(ScheduleKind::First, Accelerator::Bvh, false), 8);
        assert_eq!(first, [Generate, Setup, TraverseBvh], "others may come before the next step");
        let (first, _) = guesses(&sampled(ScheduleKind::Second, Accelerator::None, false), 4);
        assert_eq!(first, [Generate, Setup, Intersect, Intersect]);
    }

    #[test]
    fn a_guess_never_leaves_the_loop() {
        let schedule = Schedule::new(ScheduleKind::First, Accelerator::Grid, false, true, false, false);
        let mut cursor = Cursor::start();
        assert_eq!(cursor.guess(&schedule, &counts(0, 0, 0), 8), [Kernel::Generate]);
        cursor.next(&schedule, &counts(0, 0, 0));
        cursor.next(&schedule, &counts(0, 0, 0));
        assert_eq!(cursor.guess(&schedule, &counts(5, 0, 0), 4), [Kernel::Intersect; 4]);
    }

    #[test]
    fn a_guess_never_takes_a_step_that_another_kernel_may_come_before() {
        let schedule = Schedule::new(ScheduleKind::First, Accelerator::Bvh, false, true, false, false);
        let mut cursor = Cursor::start();
        for _ in 0..2 {
            cursor.next(&schedule, &counts(0, 0, 0));
        }
        // Rays that this step takes to a leaf are tested before the next one.
        assert_eq!(cursor.guess(&schedule, &counts(0, 9, 0), 8), [Kernel::TraverseBvh]);
        cursor.next(&schedule, &counts(0, 9, 0));
        assert_eq!(cursor.guess(&schedule, &counts(4, 5, 0), 3), [Kernel::Intersect; 3]);
    }
}
