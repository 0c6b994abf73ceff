//! Records of the passes that have run: their sums and, on request, each of them.

use std::collections::BTreeMap;

use crate::executor::{DrawTime, Rounding};
use crate::program::Kernel;
use crate::program::schedule::Call;
use crate::tables::kernel::Role;
use crate::tables::state::StateCounts;

/// One pass that has run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pass {
    /// Its index in the run, from 0.
    pub index: usize,
    /// The sample of every pixel that it belongs to, from 0.
    pub sample: u32,
    /// Number of iterations of the walk's loop that have begun in this sample: from 1 in the loop, 0 before it, and always
    /// 0 in a schedule whose walk is one kernel, which needs no loop. In a counted loop, the number of its turns that have
    /// begun.
    pub iteration: u32,
    /// The turns of the schedule's loops that it is in, from 0, outermost loop first.
    pub loops: Vec<u32>,
    /// The value of `launch.parameter`.
    pub parameter: u32,
    /// Its kernel.
    pub kernel: Kernel,
    /// Number of rays that it worked on; of a program without rays, of elements.
    pub rays_in: u32,
    /// Rays in each state after it.
    pub counts: StateCounts,
    /// Number of threads that it launched, with or without a ray to work on.
    ///
    /// On a GPU, whole workgroups: for a kernel that takes a list of live rays, as many full rows of workgroups as hold
    /// them; for any other, as many workgroups as cover the image. On the CPU, calls of the twin: for all rays of every
    /// chunk of 512 that has a ray in one of the kernel's states. Threads that a GPU launches to count rays, or in
    /// passes that were submitted ahead but not needed, do not count.
    pub threads_launched: u64,
    /// How long the host took to record its commands, without the translation by the driver; `None` for the twins, which
    /// need none, and without a host clock.
    pub encode_ns: Option<u64>,
    /// When it began, by the clock that timed the run: the device's own or, for the twins, the host's.
    pub begin_ns: Option<u64>,
    /// How long it took, by the same clock; `None` also if it was too short to tell, see [`below_ns`](Self::below_ns).
    pub duration_ns: Option<u64>,
    /// How well that is known, if the device's clock is coarse.
    pub rounding: Option<Rounding>,
}

impl Pass {
    /// A pass of a kernel of which nothing else is known.
    #[must_use]
    pub fn of(kernel: Kernel) -> Self {
        Self {
            index: 0,
            sample: 0,
            iteration: 0,
            loops: Vec::new(),
            parameter: kernel.instance().parameter,
            kernel,
            rays_in: 0,
            counts: StateCounts::default(),
            threads_launched: 0,
            encode_ns: None,
            begin_ns: None,
            duration_ns: None,
            rounding: None,
        }
    }

    /// Its kernel and parameter, to run it again.
    #[must_use]
    pub fn call(&self) -> Call {
        Call { kernel: self.kernel, parameter: self.parameter }
    }

    /// Its [`loops`](Self::loops) as in `passes.csv`: separated by spaces.
    #[must_use]
    pub fn loops_text(&self) -> String {
        let turns: Vec<String> = self.loops.iter().map(u32::to_string).collect();
        turns.join(" ")
    }

    /// What its duration is less than, in nanoseconds, if the device's clock is too coarse to tell how long it took.
    #[must_use]
    pub fn below_ns(&self) -> Option<u64> {
        self.rounding.filter(|_| self.duration_ns.is_none()).map(|rounding| rounding.below_ns)
    }
}

/// A kernel's share of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct KernelSummary {
    /// Number of passes.
    pub passes: usize,
    /// Rays worked on, summed over its passes; `null` unless they were counted in every pass.
    pub rays_in: Option<u64>,
    /// Time that its passes took, by the clock that timed the run: the device's or, for the twins, the host's; `null`
    /// unless every pass was timed.
    pub duration_ns: Option<u64>,
}

/// Sums over passes. Takes the same memory however many there are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassTotals {
    /// Number of passes.
    pub passes: usize,
    /// Passes, rays and time of each kernel, by name.
    pub kernels: BTreeMap<&'static str, KernelSummary>,
    /// [`Pass::threads_launched`], summed.
    pub threads_launched: u64,
    /// [`Pass::duration_ns`], summed; `None` unless every pass was timed.
    pub duration_ns: Option<u64>,
}

impl Default for PassTotals {
    fn default() -> Self {
        Self { passes: 0, kernels: BTreeMap::new(), threads_launched: 0, duration_ns: Some(0) }
    }
}

impl PassTotals {
    /// Adds a pass.
    pub fn add(&mut self, pass: &Pass) {
        self.add_counted(pass, true);
    }

    fn add_counted(&mut self, pass: &Pass, is_counted: bool) {
        let plus = |sum: Option<u64>| sum.zip(pass.duration_ns).map(|(a, b)| a.saturating_add(b));
        self.passes += 1;
        self.threads_launched += pass.threads_launched;
        self.duration_ns = plus(self.duration_ns);
        let none = KernelSummary { passes: 0, rays_in: Some(0), duration_ns: Some(0) };
        let kernel = self.kernels.entry(pass.kernel.name()).or_insert(none);
        kernel.passes += 1;
        kernel.rays_in = kernel.rays_in.filter(|_| is_counted).map(|rays| rays + u64::from(pass.rays_in));
        kernel.duration_ns = plus(kernel.duration_ns);
    }

    /// [`Pass::rays_in`], summed; `None` unless rays were counted in every pass.
    #[must_use]
    pub fn rays_in(&self) -> Option<u64> {
        self.kernels.values().map(|kernel| kernel.rays_in).sum()
    }
}

impl<'a> FromIterator<&'a Pass> for PassTotals {
    fn from_iter<I: IntoIterator<Item = &'a Pass>>(passes: I) -> Self {
        let mut totals = Self::default();
        passes.into_iter().for_each(|pass| totals.add(pass));
        totals
    }
}

/// The passes of a run so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Records {
    is_kept: bool,
    kept: Vec<Pass>,
    /// The parts of each of them, if passes are drawn.
    draws: Vec<Vec<DrawTime>>,
    totals: PassTotals,
    last: Option<Pass>,
    of_sample: usize,
}

impl Records {
    /// No passes yet; `is_kept`: keep each of them.
    pub(super) fn new(is_kept: bool) -> Self {
        Self { is_kept, ..Self::default() }
    }

    /// Removes all passes.
    pub(super) fn clear(&mut self) {
        *self = Self::new(self.is_kept);
    }

    /// Adds a pass. Unless `is_counted`, its numbers of rays are not known, and it is not kept.
    pub(super) fn push(&mut self, pass: Pass, is_counted: bool, draws: &[DrawTime]) {
        self.totals.add_counted(&pass, is_counted);
        self.of_sample = if pass.kernel.role() == Role::Source { 0 } else { self.of_sample + 1 };
        self.last = is_counted.then(|| pass.clone());
        if self.is_kept {
            self.kept.push(pass);
            if !draws.is_empty() {
                // Passes that were not drawn have no parts.
                self.draws.resize(self.kept.len() - 1, Vec::new());
                self.draws.push(draws.to_vec());
            }
        }
    }

    pub(super) fn len(&self) -> usize {
        self.totals.passes
    }

    /// Each of the passes if they are kept, else none.
    pub(super) fn kept(&self) -> &[Pass] {
        &self.kept
    }

    /// The parts of each of the kept passes up to the last one that was drawn.
    pub(super) fn draws(&self) -> &[Vec<DrawTime>] {
        &self.draws
    }

    pub(super) fn totals(&self) -> &PassTotals {
        &self.totals
    }

    pub(super) fn last(&self) -> Option<Pass> {
        self.last.clone()
    }

    /// Number of passes since rays were last generated, or since the start.
    pub(super) fn of_sample(&self) -> usize {
        self.of_sample
    }
}
