//! Who may hand work to the queue: a window configures its surface while nobody does.
//!
//! wgpu waits for the GPU before it configures a surface, refuses where somebody submitted in the meantime, and then
//! drops what it owed to read-backs that had finished. So whoever draws a window shuts the gate meanwhile.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use super::Gpu;

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
}

/// While it lives, [`Gpu::submit`] waits.
#[must_use = "work is held back only while this lives"]
pub struct Held(Arc<Gpu>);

impl Drop for Held {
    fn drop(&mut self) {
        let gate = &self.0.gate;
        *gate.holders() -= 1;
        gate.opened.notify_all();
    }
}

impl Gpu {
    /// Hands work to the queue. Waits only while somebody [holds it back](Self::hold_back), never for the GPU.
    /// All work goes this way but that of the thread that draws a window.
    pub fn submit(&self, work: impl IntoIterator<Item = wgpu::CommandBuffer>) {
        let mut holders = self.gate.holders();
        while *holders > 0 {
            holders = self.gate.opened.wait(holders).unwrap_or_else(PoisonError::into_inner);
        }
        // The lock is kept, so that nobody holds back what is halfway there.
        #[expect(clippy::disallowed_methods, reason = "the one place where it is called")]
        self.queue.submit(work);
    }

    /// Holds back everything that other threads submit, until the answer is dropped. The thread that asks for this
    /// must not submit while it has it.
    pub fn hold_back(self: &Arc<Self>) -> Held {
        *self.gate.holders() += 1;
        Held(self.clone())
    }
}
