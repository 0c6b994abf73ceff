//! The known passes of a run, and the checkpoints that are kept.
//!
//! Cost is counted in threads launched: there is no clock here. A checkpoint is taken if a replay from the previous one
//! would cost more than [`span`] allows; if they exceed the budget, those are dropped whose absence increases the
//! longest replay the least. One more is kept before the last passes, where one goes back to from the end; among many it
//! is dropped last.

use std::collections::BTreeMap;

use raystep_kernels::{Checkpoint, GpuError, Pass, RenderError, Renderer};

/// Default budget of checkpoints, in bytes.
pub const DEFAULT_BUDGET: u64 = 1 << 30;

/// Threads launched between two checkpoints: some milliseconds on a large GPU, some ten on a small one, and up to a
/// quarter of a second on a CPU.
fn span(renderer: &Renderer) -> u64 {
    match renderer.adapter().map(|gpu| gpu.info.device_type) {
        Some(wgpu::DeviceType::DiscreteGpu) => 1 << 28,
        Some(wgpu::DeviceType::Cpu) | None => 1 << 21,
        Some(_) => 1 << 26,
    }
}

/// The checkpoint before the last passes is dropped last only if there is room for so many.
const MANY: u64 = 8;
/// It is not taken if the one before it is nearer than this part of a span.
const NEAR: u64 = 8;

pub(super) struct History {
    known: Vec<Pass>,
    /// Cumulative cost of the passes, from none of them to all that are known.
    costs: Vec<u64>,
    kept: BTreeMap<usize, Checkpoint>,
    budget: u64,
    span: u64,
    /// Bytes of the last checkpoint alone.
    size: Option<u64>,
    /// Cost of a pass, until passes have shown it.
    rays: u64,
    /// The checkpoint before the last passes.
    before_end: Option<usize>,
}

impl History {
    pub(super) fn new(renderer: &Renderer) -> Self {
        Self {
            known: Vec::new(),
            costs: vec![0],
            kept: BTreeMap::new(),
            budget: DEFAULT_BUDGET,
            span: span(renderer),
            size: None,
            rays: renderer.plan().rays,
            before_end: None,
        }
    }

    pub(super) fn known(&self) -> &[Pass] {
        &self.known
    }

    /// A run's passes so far.
    pub(super) fn note(&mut self, passes: &[Pass]) {
        for pass in passes.iter().skip(self.known.len()) {
            self.known.push(pass.clone());
            self.costs.push(self.costs.last().unwrap_or(&0).saturating_add(pass.threads_launched.max(1)));
        }
    }

    /// Invalidates everything.
    pub(super) fn forget(&mut self) {
        self.forget_after(0);
        self.kept.clear();
    }

    /// Invalidates what is known after a place.
    pub(super) fn forget_after(&mut self, place: usize) {
        self.known.truncate(place);
        self.costs.truncate(place + 1);
        self.kept.split_off(&(place + 1));
        self.before_end = self.before_end.filter(|&before| before <= place);
    }

    /// Also invalidates the place itself.
    pub(super) fn forget_from(&mut self, place: usize) {
        self.forget_after(place);
        self.before_end = self.before_end.filter(|&before| before != place);
        self.kept.remove(&place);
    }

    /// The last checkpoint at or before a place.
    pub(super) fn nearest(&self, place: usize) -> Option<&Checkpoint> {
        self.kept.range(..=place).next_back().map(|(_, checkpoint)| checkpoint)
    }

    fn cost(&self, place: usize) -> u64 {
        self.costs.get(place).or(self.costs.last()).copied().unwrap_or(0)
    }

    /// Cost between checkpoints: more than the span if fewer of them fit.
    fn spacing(&self) -> u64 {
        let most = self.size.map_or(u64::MAX, |size| self.budget / size.max(1));
        self.span.max(self.cost(usize::MAX) / most.saturating_mul(2).max(1))
    }

    fn since_checkpoint(&self, place: usize) -> u64 {
        let from = self.nearest(place).map_or(0, Checkpoint::place);
        self.cost(place).saturating_sub(self.cost(from))
    }

    /// Passes after which it is time to ask for a checkpoint, if they cost as much as the last one did.
    pub(super) fn passes_to_checkpoint(&self, place: usize) -> usize {
        let last = self.known.get(place.saturating_sub(1)).map_or(self.rays, |p| p.threads_launched);
        let left = self.spacing().saturating_sub(self.since_checkpoint(place));
        usize::try_from(left / last.max(1)).unwrap_or(usize::MAX).max(1)
    }

    /// Whether the place is worth a checkpoint; `is_before_end`: only the last passes follow.
    pub(super) fn is_due(&mut self, place: usize, is_before_end: bool) -> bool {
        let fits = self.size.is_none_or(|size| size <= self.budget) && self.budget > 0;
        let since = self.since_checkpoint(place);
        let is_due = fits && (since >= self.spacing() || is_before_end && since > self.span / NEAR);
        if is_due && is_before_end {
            self.before_end = self.before_end.max(Some(place));
        }
        is_due
    }

    /// Keeps a checkpoint, and drops others if there is no room for all.
    ///
    /// # Errors
    /// Where the device failed. A device without room for more is no failure: what is kept by now has to do.
    pub(super) fn keep(&mut self, checkpoint: Result<Checkpoint, RenderError>) -> Result<(), RenderError> {
        match checkpoint {
            Ok(checkpoint) => {
                self.size = Some(checkpoint.bytes());
                self.kept.insert(checkpoint.place(), checkpoint);
                self.thin();
            }
            Err(RenderError::Gpu(GpuError::OutOfMemory(_)) | RenderError::Memory(_)) => {
                // Other allocations may fail for the same reason: free one more place.
                self.budget = self.bytes();
                self.drop_one();
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }

    fn thin(&mut self) {
        while self.bytes() > self.budget && self.drop_one() {}
    }

    /// Drops the checkpoint whose neighbours are closest together.
    fn drop_one(&mut self) -> bool {
        let places: Vec<usize> = self.kept.keys().copied().collect();
        let gap = |i: usize| {
            let before = if i == 0 { 0 } else { self.cost(places[i - 1]) };
            let after = places.get(i + 1).map_or(self.cost(usize::MAX), |&place| self.cost(place));
            after.saturating_sub(before)
        };
        let are_many = self.size.is_some_and(|size| size.saturating_mul(MANY) <= self.budget);
        let least = (0..places.len()).min_by_key(|&i| (are_many && self.before_end == Some(places[i]), gap(i)));
        least.is_some_and(|i| self.kept.remove(&places[i]).is_some())
    }

    pub(super) fn set_budget(&mut self, bytes: u64) {
        self.budget = bytes;
        self.thin();
    }

    pub(super) fn set_span(&mut self, threads: u64) {
        self.span = threads.max(1);
    }

    pub(super) fn budget(&self) -> u64 {
        self.budget
    }

    pub(super) fn bytes(&self) -> u64 {
        Checkpoint::bytes_of(self.kept.values())
    }

    pub(super) fn places(&self) -> impl Iterator<Item = usize> + '_ {
        self.kept.keys().copied()
    }
}
