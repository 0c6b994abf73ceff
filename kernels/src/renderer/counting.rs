//! Sums over all rays of what a run has counted: by pass, and over all samples.

use std::ops::{AddAssign, ControlFlow, Sub};

use super::{Pass, Progress, RenderError, Renderer};
use crate::plan::Plan;
use crate::tables::kernel::Role;
use crate::tables::stream::StreamData;

/// Sums over all rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CounterSums {
    /// Cells visited; with a BVH, nodes.
    pub cells_visited: u64,
    /// Triangles tested.
    pub triangles_tested: u64,
    /// Triangles tested again that were tested in an earlier cell or leaf; `null` if unknown: with several steps per
    /// pass, and with a BVH.
    pub repeated_tests: Option<u64>,
}

impl CounterSums {
    /// Sums the values of the `counters` stream after a run of this plan; `None` for another stream.
    #[must_use]
    pub fn of(data: &StreamData, plan: &Plan) -> Option<Self> {
        let sum = |layer| data.layer(layer).iter().map(|&n| u64::from(n)).sum();
        plan.program.results.is_some_and(|results| results.counters == data.stream).then(|| Self {
            cells_visited: sum(0),
            triangles_tested: sum(1),
            repeated_tests: plan
                .variants
                .iter()
                .find(|v| v.kernel.role() == Role::Test)
                .filter(|_| !plan.features.bvh)
                .map(|_| sum(2)),
        })
    }

    /// Nothing counted yet.
    fn none() -> Self {
        Self { repeated_tests: Some(0), ..Self::default() }
    }
}

impl AddAssign for CounterSums {
    fn add_assign(&mut self, other: Self) {
        self.cells_visited += other.cells_visited;
        self.triangles_tested += other.triangles_tested;
        self.repeated_tests = self.repeated_tests.zip(other.repeated_tests).map(|(a, b)| a + b);
    }
}

impl Sub for CounterSums {
    type Output = Self;

    /// What was added since `before`.
    fn sub(self, before: Self) -> Self {
        Self {
            cells_visited: self.cells_visited.saturating_sub(before.cells_visited),
            triangles_tested: self.triangles_tested.saturating_sub(before.triangles_tested),
            repeated_tests: self.repeated_tests.zip(before.repeated_tests).map(|(a, b)| a.saturating_sub(b)),
        }
    }
}

/// Tells pass by pass what a run adds to its counters. They restart with every sample: in its first pass that begins
/// walks, but not in a later one that continues them.
#[derive(Clone, Debug)]
pub struct Counting {
    before: CounterSums,
    /// The sample whose walks have begun.
    begun: Option<u32>,
}

impl Default for Counting {
    fn default() -> Self {
        Self { before: CounterSums::none(), begun: None }
    }
}

impl Counting {
    /// What the pass that has just run has added; it has to be told of every pass. `None` if the plan has no counters.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn added(&mut self, renderer: &Renderer, pass: &Pass) -> Result<Option<CounterSums>, RenderError> {
        let Some(now) = renderer.counter_sums().await? else { return Ok(None) };
        let begins = matches!(pass.kernel.role(), Role::Enter | Role::Whole);
        if begins && self.begun.replace(pass.sample) != Some(pass.sample) {
            self.before = CounterSums::none();
        }
        Ok(Some(now - std::mem::replace(&mut self.before, now)))
    }
}

/// What a run has counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counted {
    /// Over all passes, so over all samples.
    pub sums: CounterSums,
    /// By each pass, if that was wanted.
    pub passes: Vec<CounterSums>,
}

impl Renderer {
    /// Sums of the counters as they are now: of the latest sample. `None` if the plan has no counters.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn counter_sums(&self) -> Result<Option<CounterSums>, RenderError> {
        let Some(stream) = self.plan().counters() else { return Ok(None) };
        Ok(CounterSums::of(&self.values(stream).await?, self.plan()))
    }

    /// Runs from the start until this many passes have run, one at a time, or to the end if that comes first. Returns what
    /// each of them adds to the counters: nothing if the plan has none.
    ///
    /// # Errors
    /// As for [`run`](Self::run).
    pub async fn count_passes(
        &mut self,
        place: usize,
        mut progress: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Vec<CounterSums>, RenderError> {
        let (mut counted, mut counting) = (Vec::new(), Counting::default());
        while self.pass_count() < place {
            let Some(pass) = self.step().await? else { break };
            counted.extend(counting.added(self, &pass).await?);
            if progress(&self.progress()).is_break() && self.next_kernel().is_some() {
                return Err(RenderError::Cancelled { passes: self.pass_count() });
            }
        }
        Ok(counted)
    }

    /// Runs from the start to the end as [`run`](Self::run) does, and sums the counters of all samples; with `each_pass`
    /// also those of every pass, which then runs alone. `None` if the plan has no counters.
    ///
    /// # Errors
    /// As for `run`.
    pub async fn run_counting(
        &mut self,
        each_pass: bool,
        mut progress: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Option<Counted>, RenderError> {
        if self.plan().counters().is_none() {
            return self.run(progress).await.map(|()| None);
        }
        let mut counted = Counted { sums: CounterSums::none(), passes: Vec::new() };
        if each_pass {
            counted.passes = self.count_passes(usize::MAX, progress).await?;
            counted.passes.iter().for_each(|&pass| counted.sums += pass);
            return Ok(Some(counted));
        }
        while self.next_kernel().is_some() {
            self.run_to_sample(self.samples() + 1, &mut progress).await?;
            counted.sums += self.counter_sums().await?.unwrap_or_default();
        }
        Ok(Some(counted))
    }
}
