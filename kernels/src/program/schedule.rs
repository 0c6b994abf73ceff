//! Which kernels run, in what order and until which condition holds: a value that can be checked without a GPU.

mod cursor;

use super::instance::Kernel;
use crate::tables::elements::Elements;
use crate::tables::kernel::Role;
use crate::tables::state::Population;
pub use cursor::Cursor;

/// Most passes of a run of a user's program.
pub const MOST_PASSES: u64 = 1_000_000;
/// The same if its length depends on its elements: a loop that never ends is found within a minute on most devices.
pub const MOST_OPEN_PASSES: u64 = 200_000;

/// A step of a schedule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Run a kernel once, with its instance's parameter.
    Run(Kernel),
    /// Run a kernel once, with a parameter that counts with the loops it is in.
    RunBy(Kernel, Count),
    /// Run a kernel until no ray is active in it; not at all if none is.
    RunUntilIdle(Kernel),
    /// Repeat the steps while any ray is active in one of the kernels.
    LoopWhileActive(Vec<Kernel>, Vec<Step>),
    /// Run the steps, and repeat them while a set has elements.
    RepeatWhileAny(&'static Elements, Vec<Step>),
    /// Run the steps so many times, which may depend on the turns of the loops that it is in; and what a turn is called.
    Repeat(&'static str, Count, Vec<Step>),
}

/// A number that counts with the turns of loops: a kernel's `launch.parameter`, or how often a loop runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// In the first turn of each loop, and outside of loops.
    pub first: u32,
    /// What each turn of a loop adds, innermost loop first.
    pub by: &'static [u32],
}

impl Count {
    /// Always the same number.
    #[must_use]
    pub const fn always(number: u32) -> Self {
        Self { first: number, by: &[] }
    }

    /// The number in these turns, outermost loop first.
    fn at(self, turns: &[At]) -> u32 {
        let add = |sum: u32, (&by, at): (&u32, &At)| sum.wrapping_add(by.wrapping_mul(at.turn));
        self.by.iter().zip(turns.iter().rev()).fold(self.first, add)
    }
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
    /// Whether the number of its passes depends on the elements.
    #[must_use]
    pub fn is_open(&self) -> bool {
        fn is_open(steps: &[Step]) -> bool {
            steps.iter().any(|step| match step {
                Step::Run(_) | Step::RunBy(..) => false,
                Step::RunUntilIdle(_) | Step::LoopWhileActive(..) | Step::RepeatWhileAny(..) => true,
                Step::Repeat(_, _, steps) => is_open(steps),
            })
        }
        is_open(&self.steps)
    }

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
                    Step::Repeat(_, Count { first: 0, by: [] }, _) => {}
                    looped => collect(looped.body().unwrap_or_default(), kernels),
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
        fn of(steps: &[Step], turns: &mut Vec<At>) -> u64 {
            let mut passes: u64 = 0;
            for step in steps {
                passes = passes.saturating_add(match step {
                    Step::Run(_) | Step::RunBy(..) | Step::RunUntilIdle(_) => 1,
                    Step::LoopWhileActive(_, body) | Step::RepeatWhileAny(_, body) => {
                        turns.push(At::default());
                        let once = of(body, turns);
                        turns.pop();
                        TIMES.saturating_mul(once)
                    }
                    Step::Repeat(_, times, body) => (0..times.at(turns)).fold(0u64, |sum, turn| {
                        turns.push(At { step: 0, turn });
                        let once = of(body, turns);
                        turns.pop();
                        sum.saturating_add(once)
                    }),
                });
            }
            passes
        }
        of(&self.steps, &mut Vec::new())
    }

    /// The counts after a kernel that is not part of the walk, assuming that it sends all of its rays to the next
    /// kernel.
    fn after_all(&self, kernel: Kernel, counts: &Population) -> Population {
        let kernels = self.kernels();
        // The first state that it sends rays to and such a kernel takes.
        let sent_to = |is_taker: fn(Role) -> bool| {
            let takers = kernels.iter().filter(|taker| is_taker(taker.role()));
            takers
                .flat_map(|taker| taker.takes())
                .copied()
                .find(|tag| kernel.sends().iter().any(|sent| sent.to == *tag))
        };
        let to = match kernel.role() {
            Role::Enter => sent_to(Role::is_walk),
            // Every pixel asks for another sample.
            Role::Sample => sent_to(|role| role == Role::Source),
            _ => kernel.sends_all_to(),
        };
        let mut after = counts.clone();
        if kernel.role() == Role::Finish && to.is_none() {
            // The next kernel is the first that may have some.
            after.in_state.clear(kernel.takes().iter().copied());
            kernel.sends().iter().for_each(|sent| after.in_state.add(sent.to, kernel.live(&counts.in_state)));
        }
        if let Some(to) = to {
            after.in_state.clear(kernel.takes().iter().copied());
            after.in_state.add(to, kernel.live(&counts.in_state));
        }
        after
    }
}

/// A place in a list of steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct At {
    /// Index of the step.
    step: usize,
    /// Turns of the loop whose body the list is that are complete; 0 for the outermost list.
    turn: u32,
}
