//! Which kernels run, in what order and until which condition holds: a value that can be checked without a GPU.

use super::kernel::Kernel;
use crate::tables::kernel::{Launch, Role};
use crate::tables::state::StateCounts;

/// A step of a schedule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Run a kernel once, with its instance's parameter.
    Run(Kernel),
    /// Run a kernel once, with a parameter that counts with the innermost [counted loop](Self::Repeat).
    RunBy(Kernel, Parameter),
    /// Run a kernel until no ray is active in it; not at all if none is.
    RunUntilIdle(Kernel),
    /// Repeat the steps while any ray is active in one of the kernels.
    LoopWhileActive(Vec<Kernel>, Vec<Step>),
    /// Run the steps, and repeat them while one of the program's [counted sets](crate::program::Program::counted), named
    /// by its index, has elements. In a program without states.
    RepeatWhileAny(usize, Vec<Step>),
    /// Run the steps so many times.
    Repeat(u32, Vec<Step>),
}

/// A kernel's `launch.parameter` in a counted loop: `first` in the loop's first turn, and `by` more in each that follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// In the first turn, and outside of loops.
    pub first: u32,
    /// What each turn adds.
    pub by: u32,
}

/// A pass that is to run: a kernel with its parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// Its kernel.
    pub kernel: Kernel,
    /// The value of `launch.parameter`.
    pub parameter: u32,
}

impl Call {
    /// With the parameter of the kernel's instance.
    #[must_use]
    pub fn of(kernel: Kernel) -> Self {
        Self { kernel, parameter: kernel.instance().parameter }
    }
}

impl Step {
    /// Whether it is the walk: the steps that move rays until their hits are found.
    fn is_walk(&self) -> bool {
        match self {
            Self::Run(_) | Self::RunBy(..) | Self::RepeatWhileAny(..) | Self::Repeat(..) => false,
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
                    Step::Run(k) | Step::RunBy(k, _) | Step::RunUntilIdle(k) => {
                        if !kernels.contains(k) {
                            kernels.push(*k);
                        }
                    }
                    Step::Repeat(0, _) => {}
                    Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) | Step::Repeat(_, body) => {
                        collect(body, kernels);
                    }
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
                Step::Run(_) | Step::RunBy(..) | Step::RunUntilIdle(_) => 1,
                Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) => TIMES * of(body),
                Step::Repeat(times, body) => u64::from(*times).saturating_mul(of(body)),
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
    /// The step at each depth of nesting, outermost first.
    path: Vec<At>,
    /// Number of iterations of the walk's loop that have begun; with several samples per pixel, in this sample. In a
    /// counted loop, the number of its turns that have begun; 0 before and after it.
    pub iteration: u32,
    /// `launch.parameter` of the pass that [`next`](Self::next) returned last.
    pub parameter: u32,
    /// Number of complete samples per pixel; always 0 in a run with one sample per pixel.
    pub samples: u32,
}

/// A place in a list of steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct At {
    /// Index of the step.
    step: usize,
    /// Turns of the counted loop whose body the list is that are complete.
    turn: u32,
}

impl Cursor {
    /// The position before the first step.
    #[must_use]
    pub fn start() -> Self {
        Self { path: vec![At::default()], iteration: 0, parameter: 0, samples: 0 }
    }

    /// The kernel that runs next, given the number of rays in each state; `None` at the end. Advances past it.
    pub fn next(&mut self, schedule: &Schedule, counts: &StateCounts) -> Option<Kernel> {
        loop {
            let (steps, parent) = self.steps(schedule);
            let at = self.path.last_mut()?;
            let Some(step) = steps.get(at.step) else {
                self.end_turn(parent?, counts);
                continue;
            };
            match step {
                Step::Run(kernel) | Step::RunBy(kernel, _) => {
                    match kernel.role() {
                        Role::Source => self.iteration = 0,
                        Role::Sample => self.samples += 1,
                        _ => {}
                    }
                    self.parameter = match step {
                        Step::RunBy(_, Parameter { first, by }) => first.wrapping_add(by.wrapping_mul(at.turn)),
                        _ => kernel.instance().parameter,
                    };
                    if let Some(Step::Repeat(..)) = parent {
                        self.iteration = at.turn + 1;
                    }
                    at.step += 1;
                    return Some(*kernel);
                }
                Step::RunUntilIdle(kernel) => {
                    if kernel.live(counts) > 0 {
                        self.parameter = kernel.instance().parameter;
                        return Some(*kernel);
                    }
                    at.step += 1;
                }
                Step::LoopWhileActive(kernels, _) => {
                    if kernels.iter().any(|k| k.live(counts) > 0) {
                        self.iteration += u32::from(step.is_walk());
                        self.path.push(At::default());
                    } else {
                        at.step += 1;
                    }
                }
                Step::Repeat(0, _) => at.step += 1,
                Step::RepeatWhileAny(..) | Step::Repeat(..) => self.path.push(At::default()),
            }
        }
    }

    /// At the end of a loop's body: back to its first step, to the loop's condition, or past the loop.
    fn end_turn(&mut self, of: &Step, counts: &StateCounts) {
        let again = match (of, self.path.last_mut()) {
            (Step::RepeatWhileAny(counted, _), Some(at)) if counts[*counted] > 0 => Some(at),
            (Step::Repeat(times, _), Some(at)) if at.turn + 1 < *times => Some(at),
            _ => None,
        };
        if let Some(at) = again {
            *at = At { step: 0, turn: at.turn + 1 };
            return;
        }
        self.path.pop();
        if let (Step::RepeatWhileAny(..) | Step::Repeat(..), Some(at)) = (of, self.path.last_mut()) {
            at.step += 1;
        }
        if let Step::Repeat(..) = of {
            self.iteration = 0;
        }
    }

    /// Whether it is not known without the latest counts which kernel is next: repeated steps have come to their end.
    fn may_repeat(&self, schedule: &Schedule) -> bool {
        let mut ahead = self.clone();
        loop {
            let (steps, parent) = ahead.steps(schedule);
            match (ahead.path.last_mut().and_then(|at| steps.get(at.step).map(|step| (step, at))), parent) {
                (Some((Step::Repeat(0, _), at)), _) => at.step += 1,
                (Some(_), _) | (None, None) => return false,
                (None, Some(Step::RepeatWhileAny(..))) => return true,
                (None, Some(of)) => ahead.end_turn(of, &StateCounts::default()),
            }
        }
    }

    /// The position right before the last step it advanced past, as far as counts tell.
    #[cfg(test)]
    pub(crate) fn before(&self) -> Self {
        let mut before = self.clone();
        if let Some(last) = before.path.last_mut() {
            last.step -= 1;
        }
        before
    }

    /// Advances past the walk, even if rays are still active in it; does nothing outside of the walk.
    pub fn leave_walk(&mut self, schedule: &Schedule) {
        if let Some(depth) = self.walk_depth(schedule) {
            self.path.truncate(depth + 1);
            self.path[depth].step += 1;
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
    pub fn guess(&self, schedule: &Schedule, counts: &StateCounts, most: usize) -> Vec<Call> {
        let mut cursor = self.clone();
        let Some(first) = cursor.next(schedule, counts) else { return Vec::new() };
        let call = |kernel, cursor: &Self| Call { kernel, parameter: cursor.parameter };
        let mut calls = vec![call(first, &cursor)];
        let mut counts = *counts;
        let mut last = first;
        // These kernels run once, whatever they find, so the next pass is known.
        while last.role() == Role::Once && calls.len() < most && !cursor.may_repeat(schedule) {
            match cursor.next(schedule, &counts) {
                Some(next) if next.role() == Role::Once => {
                    calls.push(call(next, &cursor));
                    last = next;
                }
                _ => return calls,
            }
        }
        // It is not known ahead whether a kernel that runs until it is idle runs again.
        while schedule.has_samples() && !last.is_walk() && !cursor.stays(schedule, last) {
            counts = schedule.after_all(last, &counts);
            match cursor.next(schedule, &counts) {
                // The fused kernel is submitted alone: it runs in bands, and its rays are counted afterwards.
                Some(next) if calls.len() < most && [last, next].iter().all(|k| k.info().launch != Launch::Bands) => {
                    calls.push(call(next, &cursor));
                    last = next;
                }
                _ => return calls,
            }
        }
        // Only inside of the loop may a pass be repeated for nothing.
        if !cursor.in_walk(schedule) {
            return calls;
        }
        while calls.len() < most.max(1) {
            let mut ahead = cursor.clone();
            match ahead.next(schedule, &counts) {
                // A kernel that runs once per iteration is idle right after; guessing it again would be a waste.
                Some(kernel)
                    if ahead.in_walk(schedule)
                        && (calls.last().is_none_or(|last| last.kernel != kernel) || ahead.stays(schedule, kernel)) =>
                {
                    calls.push(call(kernel, &ahead));
                }
                _ => break,
            }
            cursor = ahead;
        }
        calls
    }

    /// Whether the step at the cursor may run the kernel again at once, right after it ran.
    fn stays(&self, schedule: &Schedule, kernel: Kernel) -> bool {
        let step = self.path.last().map_or(0, |at| at.step);
        matches!(self.steps(schedule).0.get(step), Some(Step::RunUntilIdle(again)) if *again == kernel)
    }

    fn in_walk(&self, schedule: &Schedule) -> bool {
        self.walk_depth(schedule).is_some()
    }

    /// The depth of nesting of the walk that the cursor is in or right before.
    fn walk_depth(&self, schedule: &Schedule) -> Option<usize> {
        let mut steps = schedule.steps.as_slice();
        for (depth, at) in self.path.iter().enumerate() {
            match steps.get(at.step)? {
                step if step.is_walk() => return Some(depth),
                Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) | Step::Repeat(_, body) => steps = body,
                _ => return None,
            }
        }
        None
    }

    /// The steps at the innermost depth, and the loop whose body they are.
    fn steps<'a>(&self, schedule: &'a Schedule) -> (&'a [Step], Option<&'a Step>) {
        let (mut steps, mut parent) = (schedule.steps.as_slice(), None);
        for at in &self.path[..self.path.len() - 1] {
            let step = &steps[at.step];
            let (Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) | Step::Repeat(_, body)) = step else {
                break;
            };
            (steps, parent) = (body, Some(step));
        }
        (steps, parent)
    }
}
