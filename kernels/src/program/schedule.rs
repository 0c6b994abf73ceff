//! Which kernels run, in what order, until what holds: a value that can be checked without a GPU.

use super::kernel::Kernel;
use crate::tables::kernel::{Launch, Role};
use crate::tables::state::StateCounts;

/// One line of a schedule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Run a kernel once.
    Run(Kernel),
    /// Run a kernel until no ray is active there; not at all if none is.
    RunUntilIdle(Kernel),
    /// Run the steps again and again while any ray is active in one of the kernels.
    LoopWhileActive(Vec<Kernel>, Vec<Step>),
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
        let [Step::LoopWhileActive(kernels, _)] = self.steps.as_slice() else { return false };
        matches!(kernels[..], [kernel] if kernel.role() == Role::Source)
    }

    /// The counts after a kernel that is no part of the walk, if it sent all of its rays on to the next kernel.
    fn after_all(&self, kernel: Kernel, counts: &StateCounts) -> StateCounts {
        let first_taken = |is_taker: fn(Role) -> bool| {
            self.kernels().into_iter().find(|k| is_taker(k.role())).and_then(|k| k.info().takes.first().copied())
        };
        let to = match kernel.role() {
            Role::Enter => first_taken(Role::is_walk),
            // Every pixel wants another sample.
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
            }
        }
    }

    /// Right before the step that it has moved past, as far as counts go.
    #[cfg(test)]
    pub(crate) fn before(&self) -> Self {
        let mut before = self.clone();
        if let Some(last) = before.path.last_mut() {
            *last -= 1;
        }
        before
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
        // Nothing that a pass finds changes which pass comes next.
        while last.role() == Role::Once && kernels.len() < most {
            match cursor.next(schedule, &counts) {
                Some(next) if next.role() == Role::Once => {
                    kernels.push(next);
                    last = next;
                }
                _ => return kernels,
            }
        }
        // Whether a kernel that runs until it is idle runs again is not known ahead.
        while schedule.has_samples() && !last.is_walk() && !cursor.stays(schedule, last) {
            counts = schedule.after_all(last, &counts);
            match cursor.next(schedule, &counts) {
                // The fused kernel is submitted alone: in parts, and what it did is counted anew.
                Some(next) if kernels.len() < most && [last, next].iter().all(|k| k.info().launch != Launch::Bands) => {
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
