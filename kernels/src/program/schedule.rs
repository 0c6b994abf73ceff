//! Which kernels run, in what order and until which condition holds: a value that can be checked without a GPU.

use super::kernel::Kernel;
use crate::tables::kernel::{Launch, Role};
use crate::tables::state::StateCounts;

/// A step of a schedule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Run a kernel once.
    Run(Kernel),
    /// Run a kernel until no ray is active in it; not at all if none is.
    RunUntilIdle(Kernel),
    /// Repeat the steps while any ray is active in one of the kernels.
    LoopWhileActive(Vec<Kernel>, Vec<Step>),
    /// Run the steps, and repeat them while one of the program's [counted sets](crate::program::Program::counted), named
    /// by its index, has elements. In a program without states.
    RepeatWhileAny(usize, Vec<Step>),
}

impl Step {
    /// Whether it is the walk: the steps that move rays until their hits are found.
    fn is_walk(&self) -> bool {
        match self {
            Self::Run(_) | Self::RepeatWhileAny(..) => false,
            Self::RunUntilIdle(kernel) => kernel.is_walk(),
            Self::LoopWhileActive(kernels, _) => kernels.iter().all(|k| k.is_walk()),
        }
    }
}

/// The order in which kernels run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// The steps, first to last.
    pub steps: Vec<Step>,
}

impl Schedule {
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
                    Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) => collect(body, kernels),
                }
            }
        }
        let mut kernels = Vec::new();
        collect(&self.steps, &mut kernels);
        kernels
    }
}

impl Schedule {
    /// About how many passes a run of kernels that run once takes: steps that are repeated are mostly so a few times.
    #[must_use]
    pub fn passes_expected(&self) -> u64 {
        const TIMES: u64 = 5;
        fn of(steps: &[Step]) -> u64 {
            let of_step = |step: &Step| match step {
                Step::Run(_) | Step::RunUntilIdle(_) => 1,
                Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) => TIMES * of(body),
            };
            steps.iter().map(of_step).sum()
        }
        of(&self.steps)
    }

    /// Whether it repeats its steps for every sample.
    fn has_samples(&self) -> bool {
        let [Step::LoopWhileActive(kernels, _)] = self.steps.as_slice() else { return false };
        matches!(kernels[..], [kernel] if kernel.role() == Role::Source)
    }

    /// The counts after a kernel that is not part of the walk, assuming that it sends all of its rays to the next
    /// kernel.
    fn after_all(&self, kernel: Kernel, counts: &StateCounts) -> StateCounts {
        let first_taken = |is_taker: fn(Role) -> bool| {
            self.kernels().into_iter().find(|k| is_taker(k.role())).and_then(|k| k.info().takes.first().copied())
        };
        let to = match kernel.role() {
            Role::Enter => first_taken(Role::is_walk),
            // Every pixel asks for another sample.
            Role::Sample => first_taken(|role| role == Role::Source),
            _ => kernel.sends_all_to(),
        };
        let mut after = *counts;
        if let Some(to) = to {
            kernel.info().takes.iter().for_each(|&tag| after[tag as usize] = 0);
            after[to as usize] += kernel.live(counts);
        }
        after
    }
}

/// A position in a schedule. Advancing a clone with guessed counts tells which passes may come next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cursor {
    /// Index of the step at each depth of nesting, outermost first.
    path: Vec<usize>,
    /// Number of iterations of the walk's loop that have begun; with several samples per pixel, in this sample.
    pub iteration: u32,
    /// Number of complete samples per pixel; always 0 in a run with one sample per pixel.
    pub samples: u32,
}

impl Cursor {
    /// The position before the first step.
    #[must_use]
    pub fn start() -> Self {
        Self { path: vec![0], iteration: 0, samples: 0 }
    }

    /// The kernel that runs next, given the number of rays in each state; `None` at the end. Advances past it.
    pub fn next(&mut self, schedule: &Schedule, counts: &StateCounts) -> Option<Kernel> {
        loop {
            let (steps, parent) = self.steps(schedule);
            let index = *self.path.last()?;
            let Some(step) = steps.get(index) else {
                // End of a loop's body: back to the loop's condition; else the end of the schedule.
                match parent? {
                    Step::RepeatWhileAny(counted, _) if counts[*counted] > 0 => *self.path.last_mut()? = 0,
                    Step::RepeatWhileAny(..) => {
                        self.path.pop();
                        *self.path.last_mut()? += 1;
                    }
                    _ => _ = self.path.pop(),
                }
                continue;
            };
            match step {
                Step::Run(kernel) => {
                    match kernel.role() {
                        Role::Source => self.iteration = 0,
                        Role::Sample => self.samples += 1,
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
                Step::RepeatWhileAny(..) => self.path.push(0),
            }
        }
    }

    /// Whether it is not known without the latest counts which kernel is next: repeated steps have come to their end.
    fn may_repeat(&self, schedule: &Schedule) -> bool {
        let (steps, parent) = self.steps(schedule);
        matches!(parent, Some(Step::RepeatWhileAny(..))) && self.path.last().is_some_and(|&index| index >= steps.len())
    }

    /// The position right before the last step it advanced past, as far as counts tell.
    #[cfg(test)]
    pub(crate) fn before(&self) -> Self {
        let mut before = self.clone();
        if let Some(last) = before.path.last_mut() {
            *last -= 1;
        }
        before
    }

    /// Advances past the walk, even if rays are still active in it; does nothing outside of the walk.
    pub fn leave_walk(&mut self, schedule: &Schedule) {
        if let Some(depth) = self.walk_depth(schedule) {
            self.path.truncate(depth + 1);
            self.path[depth] += 1;
        }
    }

    /// The next passes if every ray stayed in its state: these may be submitted before the counts of the first are
    /// known. A pass without active rays changes nothing, so a wrong guess is harmless as long as it only repeats
    /// kernels that have become idle.
    ///
    /// With several samples per pixel, also the steps from the end of a walk into the next sample, assuming that there
    /// is one and that every ray begins to walk: if not, these passes find no rays either. So a sample costs about one
    /// submission.
    #[must_use]
    pub fn guess(&self, schedule: &Schedule, counts: &StateCounts, most: usize) -> Vec<Kernel> {
        let mut cursor = self.clone();
        let Some(first) = cursor.next(schedule, counts) else { return Vec::new() };
        let mut kernels = vec![first];
        let mut counts = *counts;
        let mut last = first;
        // These kernels run once, whatever they find, so the next pass is known.
        while last.role() == Role::Once && kernels.len() < most && !cursor.may_repeat(schedule) {
            match cursor.next(schedule, &counts) {
                Some(next) if next.role() == Role::Once => {
                    kernels.push(next);
                    last = next;
                }
                _ => return kernels,
            }
        }
        // It is not known ahead whether a kernel that runs until it is idle runs again.
        while schedule.has_samples() && !last.is_walk() && !cursor.stays(schedule, last) {
            counts = schedule.after_all(last, &counts);
            match cursor.next(schedule, &counts) {
                // The fused kernel is submitted alone: it runs in bands, and its rays are counted afterwards.
                Some(next) if kernels.len() < most && [last, next].iter().all(|k| k.info().launch != Launch::Bands) => {
                    kernels.push(next);
                    last = next;
                }
                _ => return kernels,
            }
        }
        // Only inside of the loop may a pass be repeated for nothing.
        if !cursor.in_walk(schedule) {
            return kernels;
        }
        while kernels.len() < most.max(1) {
            let mut ahead = cursor.clone();
            match ahead.next(schedule, &counts) {
                // A kernel that runs once per iteration is idle right after; guessing it again would be a waste.
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

    /// Whether the step at the cursor may run the kernel again at once, right after it ran.
    fn stays(&self, schedule: &Schedule, kernel: Kernel) -> bool {
        let index = self.path.last().copied().unwrap_or(0);
        matches!(self.steps(schedule).0.get(index), Some(Step::RunUntilIdle(again)) if *again == kernel)
    }

    fn in_walk(&self, schedule: &Schedule) -> bool {
        self.walk_depth(schedule).is_some()
    }

    /// The depth of nesting of the walk that the cursor is in or right before.
    fn walk_depth(&self, schedule: &Schedule) -> Option<usize> {
        let mut steps = schedule.steps.as_slice();
        for (depth, &index) in self.path.iter().enumerate() {
            match steps.get(index)? {
                step if step.is_walk() => return Some(depth),
                Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) => steps = body,
                _ => return None,
            }
        }
        None
    }

    /// The steps at the innermost depth, and the loop whose body they are.
    fn steps<'a>(&self, schedule: &'a Schedule) -> (&'a [Step], Option<&'a Step>) {
        let (mut steps, mut parent) = (schedule.steps.as_slice(), None);
        for &index in &self.path[..self.path.len() - 1] {
            let step = &steps[index];
            let (Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body)) = step else { break };
            (steps, parent) = (body, Some(step));
        }
        (steps, parent)
    }
}
