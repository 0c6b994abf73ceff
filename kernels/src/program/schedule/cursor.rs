//! A position in a schedule: which kernel runs next, and which passes may be submitted before the counts are known.

use super::{At, Call, Schedule, Step};
use crate::program::instance::Kernel;
use crate::tables::kernel::Role;
use crate::tables::state::Population;

/// A position in a schedule. Advancing a clone with guessed counts tells which passes may come next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cursor {
    /// The step at each depth of nesting, outermost first.
    path: Vec<At>,
    /// Number of iterations of the walk's loop that have begun; with several samples per pixel, in this sample. In a
    /// counted loop, the number of its turns that have begun; 0 before and after it. All loops: [`loops`](Self::loops).
    pub iteration: u32,
    /// `launch.parameter` of the pass that [`next`](Self::next) returned last.
    pub parameter: u32,
    /// Number of complete samples per pixel; always 0 in a run with one sample per pixel.
    pub samples: u32,
}

impl Cursor {
    /// The turns of the loops that the pass which [`next`](Self::next) returned last is in, from 0, outermost first.
    #[must_use]
    pub fn loops(&self) -> Vec<u32> {
        self.path[1..].iter().map(|at| at.turn).collect()
    }

    /// The position before the first step.
    #[must_use]
    pub fn start() -> Self {
        Self { path: vec![At::default()], iteration: 0, parameter: 0, samples: 0 }
    }

    /// The kernel that runs next, given the number of rays in each state; `None` at the end. Advances past it.
    pub fn next(&mut self, schedule: &Schedule, counts: &Population) -> Option<Kernel> {
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
                    if let Some(Step::Repeat(..)) = parent {
                        self.iteration = at.turn + 1;
                    }
                    at.step += 1;
                    self.parameter = match step {
                        Step::RunBy(_, parameter) => parameter.at(&self.path[1..]),
                        _ => kernel.instance().parameter,
                    };
                    return Some(*kernel);
                }
                Step::RunUntilIdle(kernel) => {
                    if kernel.live(&counts.in_state) > 0 {
                        self.parameter = kernel.instance().parameter;
                        return Some(*kernel);
                    }
                    at.step += 1;
                }
                Step::LoopWhileActive(kernels, _) => {
                    if kernels.iter().any(|k| k.live(&counts.in_state) > 0) {
                        self.iteration += u32::from(step.is_walk());
                        self.path.push(At::default());
                    } else {
                        at.step += 1;
                    }
                }
                Step::Repeat(_, times, _) if times.at(&self.path[1..]) == 0 => self.pass_step(),
                Step::RepeatWhileAny(..) | Step::Repeat(..) => self.path.push(At::default()),
            }
        }
    }

    /// Goes on to the next step of the innermost list.
    fn pass_step(&mut self) {
        self.path.last_mut().into_iter().for_each(|at| at.step += 1);
    }

    /// At the end of a loop's body: back to its first step, to the loop's condition, or past the loop.
    fn end_turn(&mut self, of: &Step, counts: &Population) {
        let Some(At { turn, .. }) = self.path.pop() else { return };
        let goes_on = match of {
            Step::RepeatWhileAny(counted, _) => counts.of(counted) > 0,
            Step::Repeat(_, times, _) => turn + 1 < times.at(&self.path[1..]),
            Step::LoopWhileActive(kernels, _) => kernels.iter().any(|k| k.live(&counts.in_state) > 0),
            _ => false,
        };
        if goes_on {
            self.iteration += u32::from(of.is_walk());
            self.path.push(At { step: 0, turn: turn + 1 });
            return;
        }
        self.pass_step();
        if let Step::Repeat(..) = of {
            self.iteration = 0;
        }
    }

    /// Whether it is not known without the latest counts which kernel is next: repeated steps have come to their end.
    fn may_repeat(&self, schedule: &Schedule) -> bool {
        let mut ahead = self.clone();
        loop {
            let (steps, parent) = ahead.steps(schedule);
            match (ahead.path.last().and_then(|at| steps.get(at.step)), parent) {
                (Some(Step::Repeat(_, times, _)), _) if times.at(&ahead.path[1..]) == 0 => ahead.pass_step(),
                (Some(_), _) | (None, None) => return false,
                (None, Some(Step::RepeatWhileAny(..))) => return true,
                (None, Some(of)) => ahead.end_turn(of, &Population::default()),
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
    /// In a loop around the walk, such as that over samples, also the steps from the end of a walk into the next turn,
    /// assuming that there is one and that every ray begins to walk: if not, these passes find no rays either. So a sample
    /// costs about one submission.
    ///
    /// `is_alone`: kernels that are submitted alone.
    #[must_use]
    pub fn guess(
        &self,
        schedule: &Schedule,
        counts: &Population,
        most: usize,
        is_alone: impl Fn(Kernel) -> bool,
    ) -> Vec<Call> {
        let mut cursor = self.clone();
        let Some(first) = cursor.next(schedule, counts) else { return Vec::new() };
        let call = |kernel, cursor: &Self| Call { kernel, parameter: cursor.parameter };
        let mut calls = vec![call(first, &cursor)];
        let mut counts = counts.clone();
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
        while cursor.path.len() > 1 && last.role() != Role::Once && !last.is_walk() && !cursor.stays(schedule, last) {
            counts = schedule.after_all(last, &counts);
            match cursor.next(schedule, &counts) {
                Some(next) if calls.len() < most && !is_alone(last) && !is_alone(next) => {
                    calls.push(call(next, &cursor));
                    last = next;
                }
                _ => return calls,
            }
        }
        // Only inside of the loop may a pass be repeated for nothing.
        if !cursor.in_walk(schedule) || is_alone(last) {
            return calls;
        }
        while calls.len() < most.max(1) {
            let mut ahead = cursor.clone();
            match ahead.next(schedule, &counts) {
                // A kernel that runs once per iteration is idle right after; guessing it again would be a waste.
                Some(kernel)
                    if ahead.in_walk(schedule)
                        && !is_alone(kernel)
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
                step => steps = step.body()?,
            }
        }
        None
    }

    /// The steps at the innermost depth, and the loop whose body they are.
    fn steps<'a>(&self, schedule: &'a Schedule) -> (&'a [Step], Option<&'a Step>) {
        let (mut steps, mut parent) = (schedule.steps.as_slice(), None);
        for at in &self.path[..self.path.len() - 1] {
            let step = &steps[at.step];
            let Some(body) = step.body() else { break };
            (steps, parent) = (body, Some(step));
        }
        (steps, parent)
    }
}
