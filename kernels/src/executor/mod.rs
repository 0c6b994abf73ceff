//! Runs the passes, on a wgpu adapter or with the twins on the CPU. Both keep the same streams.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
pub(crate) mod sizes;

use crate::program::Kernel;
use crate::tables::state::StateCounts;
pub use sizes::TooMany;

/// What one pass did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassResult {
    /// The kernel that ran.
    pub kernel: Kernel,
    /// Rays in each state after it.
    pub counts: StateCounts,
    /// Number of elements it was launched over.
    pub elements: u32,
    /// Threads launched, see [`crate::Pass::threads_launched`].
    pub threads_launched: u64,
    /// When it began, on the executor's clock; `None` if passes were not timed.
    pub begin_ns: Option<u64>,
    /// How long it took; `None` if passes were not timed or the timer's value is not valid.
    pub duration_ns: Option<u64>,
}
