//! Controls who may submit to the queue: a window configures its surface while nobody does.
//!
//! Before configuring a surface, wgpu waits for the GPU; it fails if somebody submitted in the meantime, and then drops
//! the pending results of read-backs that had finished. So whoever draws a window closes the gate meanwhile.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

#[derive(Debug, Default)]
pub(super) struct Gate {
    /// Number of guards that hold it closed.
    holders: Mutex<usize>,
    opened: Condvar,
}

impl Gate {
    fn holders(&self) -> MutexGuard<'_, usize> {
        self.holders.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does `work` as soon as nobody holds it back. The lock is kept meanwhile, so that the gate cannot close during
    /// `work`.
    pub(super) fn pass(&self, work: impl FnOnce()) {
        let mut holders = self.holders();
        while *holders > 0 {
            holders = self.opened.wait(holders).unwrap_or_else(PoisonError::into_inner);
        }
        work();
    }

    /// Holds work back until the returned guard is dropped.
    pub(super) fn hold_back(self: &Arc<Self>) -> Held {
        *self.holders() += 1;
        Held(self.clone())
    }
}

/// While it exists, [`Gpu::submit`](super::Gpu::submit) waits.
#[must_use = "work is held back only while this lives"]
pub struct Held(Arc<Gate>);

impl Drop for Held {
    fn drop(&mut self) {
        *self.0.holders() -= 1;
        self.0.opened.notify_all();
    }
}
