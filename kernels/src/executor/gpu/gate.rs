//! Who may hand work to the queue: a window configures its surface while nobody does.
//!
//! wgpu waits for the GPU before it configures a surface, refuses where somebody submitted in the meantime, and then
//! drops what it owed to read-backs that had finished. So whoever draws a window shuts the gate meanwhile.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

#[derive(Debug, Default)]
pub(super) struct Gate {
    /// How many hold it shut.
    holders: Mutex<usize>,
    opened: Condvar,
}

impl Gate {
    fn holders(&self) -> MutexGuard<'_, usize> {
        self.holders.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does `work` as soon as nobody holds it back. The lock is kept meanwhile, so that nobody holds back what is
    /// halfway there.
    pub(super) fn pass(&self, work: impl FnOnce()) {
        let mut holders = self.holders();
        while *holders > 0 {
            holders = self.opened.wait(holders).unwrap_or_else(PoisonError::into_inner);
        }
        work();
    }

    /// Holds work back until the answer is dropped.
    pub(super) fn hold_back(self: &Arc<Self>) -> Held {
        *self.holders() += 1;
        Held(self.clone())
    }
}

/// While it lives, [`Gpu::submit`](super::Gpu::submit) waits.
#[must_use = "work is held back only while this lives"]
pub struct Held(Arc<Gate>);

impl Drop for Held {
    fn drop(&mut self) {
        *self.0.holders() -= 1;
        self.0.opened.notify_all();
    }
}
