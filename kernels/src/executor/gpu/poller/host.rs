//! Without a thread only the host polls: it is told whether it has to.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts a device's pending read-backs.
#[derive(Default)]
pub(crate) struct Poller(Arc<AtomicUsize>);

/// A pending read-back. Dropped when it has arrived or was cancelled.
pub(crate) struct Expected(Arc<AtomicUsize>);

impl Poller {
    pub(crate) fn expect(&self, _device: &wgpu::Device) -> Expected {
        self.0.fetch_add(1, Ordering::Relaxed);
        Expected(self.0.clone())
    }

    pub(crate) fn is_expecting(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }

    pub(crate) fn host_begins(&self) {}

    pub(crate) fn host_ends(&self, _device: &wgpu::Device) {}

    pub(crate) fn end(&self, _patience: std::time::Duration) -> bool {
        true
    }
}

impl Drop for Expected {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}
