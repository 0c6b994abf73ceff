//! Records of the passes that have run: their sums and, on request, each of them.

use std::collections::BTreeMap;

use super::Pass;
use crate::executor::DrawTime;
use crate::tables::kernel::Role;

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
        self.last = Some(pass).filter(|_| is_counted);
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
        self.last
    }

    /// Number of passes since rays were last generated, or since the start.
    pub(super) fn of_sample(&self) -> usize {
        self.of_sample
    }
}
