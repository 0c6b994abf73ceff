//! What an engine runs on.

use std::sync::Arc;

use raystep_kernels::Gpu;

use super::measure::Measure;

/// The devices of an engine.
#[derive(Clone)]
pub struct Devices {
    /// The adapter that the window renders with.
    pub gpu: Arc<Gpu>,
    /// A clock in nanoseconds, to time the CPU reference's passes.
    pub clock: Option<fn() -> u64>,
    /// Measures choices.
    pub measure: Measure,
    /// Called after every answer, to wake the user interface.
    pub wake: Arc<dyn Fn() + Send + Sync>,
}
