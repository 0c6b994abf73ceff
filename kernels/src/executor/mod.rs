//! Runs the passes, on a wgpu adapter or with the twins on the CPU. Both keep the same streams.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
pub(crate) mod sizes;

use crate::program::Kernel;
use crate::tables::state::StateCounts;
pub use sizes::TooMany;

/// A part of a pass that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawing {
    /// Copies of the streams that the kernel reads and writes.
    Copies,
    /// The draw that turns states into depths.
    Depths,
    /// A draw of the kernel: its index in [`DrawnKernel::draws`](crate::fragment::DrawnKernel::draws).
    Draw(usize),
}

/// A part of a pass that is drawn, and how long it took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawTime {
    /// What it is.
    pub what: Drawing,
    /// When it began, on the executor's clock; `None` if passes were not timed.
    pub begin_ns: Option<u64>,
    /// How long it took; `None` if passes were not timed, or the timer's value is not valid.
    pub duration_ns: Option<u64>,
    /// Fragments for which its program ran, by the device's pipeline statistics; `None` if they were not asked for.
    pub fragments: Option<u64>,
}

/// Does some work; also returns the nanoseconds that it took, if there is a clock.
#[cfg(feature = "gpu")]
pub(crate) fn timed<T>(clock: Option<fn() -> u64>, work: impl FnOnce() -> T) -> (T, Option<u64>) {
    let begin = clock.map(|now| now());
    let done = work();
    (done, clock.zip(begin).map(|(now, begin)| now().saturating_sub(begin)))
}

/// What one pass did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassResult {
    /// The kernel that ran.
    pub kernel: Kernel,
    /// Rays in each state after it; `None` if they were not counted.
    pub counts: Option<StateCounts>,
    /// Number of elements in each set of the program.
    pub sizes: Vec<u32>,
    /// Whether any ray was in one of its states, if an occlusion query was asked.
    pub is_active: Option<bool>,
    /// Number of elements it was launched over.
    pub elements: u32,
    /// Threads launched, see [`crate::Pass::threads_launched`].
    pub threads_launched: u64,
    /// How long the host took to record its commands; `None` if it records none, or there is no host clock.
    pub encode_ns: Option<u64>,
    /// When it began, on the executor's clock; `None` if passes were not timed.
    pub begin_ns: Option<u64>,
    /// How long it took; `None` if passes were not timed, the timer's value is not valid, or it was too short to tell.
    pub duration_ns: Option<u64>,
    /// How well that is known, if the clock is coarse.
    pub rounding: Option<Rounding>,
    /// Its parts, in order, if it was drawn.
    pub draws: Vec<DrawTime>,
}

/// How well a pass's duration is known, by a clock that rounds times to multiples of a step of 10 µs or more, as browsers
/// round the timestamps of GPUs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounding {
    /// How often the pass ran and was timed, each time on the same streams; its duration is the mean.
    pub runs: u32,
    /// Largest standard error of the duration by rounding, in nanoseconds: step / (2 √runs). How much the runs themselves
    /// differ is not known.
    pub error_ns: u64,
    /// What the duration is certainly less than, in nanoseconds: the mean and a step.
    pub below_ns: u64,
}
