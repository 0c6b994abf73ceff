//! A checkpoint: a run can return to it without running its passes again.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::device::Kept;
use super::records::Records;
use super::{RenderError, Renderer};
use crate::plan::Plan;
use crate::program::schedule::Cursor;
use crate::tables::state::Population;

/// Everything that later passes depend on, after some pass of a run. A GPU's streams are kept on the GPU.
pub struct Checkpoint {
    plan: Arc<Plan>,
    kept: Kept,
    cursor: Cursor,
    population: Population,
    believed: Option<Population>,
    records: Records,
    unfinished: u64,
    alone: Option<[u32; 2]>,
}

impl Checkpoint {
    /// Number of passes before it.
    #[must_use]
    pub fn place(&self) -> usize {
        self.records.len()
    }

    /// Size in bytes, on the GPU or on the host.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        Self::bytes_of([self])
    }

    /// Size in bytes of several checkpoints together: a stream that did not change between them is kept only once.
    #[must_use]
    pub fn bytes_of<'a>(checkpoints: impl IntoIterator<Item = &'a Self>) -> u64 {
        let parts: BTreeMap<usize, u64> = checkpoints.into_iter().flat_map(Self::parts).collect();
        parts.values().sum()
    }

    /// The identity and size in bytes of each part.
    fn parts(&self) -> Vec<(usize, u64)> {
        let mut parts = self.kept.parts();
        parts.push((self.records.kept().as_ptr().addr(), size_of_val(self.records.kept()) as u64));
        parts
    }
}

impl Renderer {
    /// Makes a checkpoint of the run. [`restore`](Self::restore) returns to it, bit for bit.
    ///
    /// # Errors
    /// If there is no memory for it, or the device fails.
    pub async fn checkpoint(&mut self) -> Result<Checkpoint, RenderError> {
        self.settle().await?;
        let kept = self.executor.snapshot(&self.population.in_state).await?;
        Ok(Checkpoint {
            plan: self.plan.clone(),
            kept,
            cursor: self.cursor.clone(),
            population: self.population.clone(),
            believed: self.believed.clone(),
            records: self.records.clone(),
            unfinished: self.unfinished,
            alone: self.alone,
        })
    }

    /// Returns to a checkpoint, behind or ahead of the current pass. The passes that follow are the same as the first
    /// time.
    ///
    /// # Errors
    /// If the checkpoint is not of this run, nor of one that shares its plan and device. Nothing is changed then.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RenderError> {
        if !Arc::ptr_eq(&self.plan, &checkpoint.plan) {
            return Err(RenderError::OtherRun);
        }
        self.executor.restore(&checkpoint.kept)?;
        self.cursor = checkpoint.cursor.clone();
        self.population = checkpoint.population.clone();
        self.believed.clone_from(&checkpoint.believed);
        self.records.clone_from(&checkpoint.records);
        self.unfinished = checkpoint.unfinished;
        self.alone = checkpoint.alone;
        self.is_ahead = false;
        Ok(())
    }
}
