//! What can go wrong with a device.

use crate::executor::TooMany;

/// An error of the device.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// No adapter, or none with that name.
    #[error("no GPU adapter {0}")]
    NoAdapter(String),
    /// The adapter gives no device.
    #[error("cannot open a device on the adapter {adapter:?}: {message}")]
    NoDevice {
        /// The adapter.
        adapter: String,
        /// The adapter's message.
        message: String,
    },
    /// The device was lost.
    #[error("the GPU device was lost ({0}), with all data on it; run again, or with --device cpu")]
    Lost(String),
    /// Not enough memory.
    #[error("the GPU does not have enough memory: {0}")]
    OutOfMemory(String),
    /// The device refused a call. This is a defect of raystep or of the driver.
    #[error("the GPU device refused a call: {0}")]
    Refused(String),
    /// A loop of a user's kernel did not end.
    #[error(
        "{place}: a loop has not ended after {turns} turns of a thread, the most that a pass may have on this device; \
         --device cpu has more"
    )]
    Endless {
        /// Its place.
        place: String,
        /// Turns that one thread may take.
        turns: u32,
    },
    /// What a user's kernel asserts does not hold.
    #[error(
        "{file}: the assertion {label:?} does not hold for {count} elements of a pass; {by} names the line and the first element"
    )]
    Assertion {
        /// The user's file.
        file: String,
        /// The assertion.
        label: String,
        /// How often it did not hold in the pass.
        count: u32,
        /// What names the line and the first element.
        by: &'static str,
    },
    /// A read-back failed.
    #[error("reading back from the GPU failed: {0}")]
    Readback(String),
    /// A stream or kernel that the plan left out.
    #[error("{0:?} is not part of this run's plan")]
    Missing(&'static str),
    /// The run has found more elements than fit.
    #[error(transparent)]
    TooMany(#[from] TooMany),
}

impl From<wgpu::Error> for GpuError {
    fn from(error: wgpu::Error) -> Self {
        match &error {
            wgpu::Error::OutOfMemory { .. } => Self::OutOfMemory(first_line(&error.to_string())),
            _ => Self::Refused(first_line(&error.to_string())),
        }
    }
}

/// Formats wgpu's chain of causes as one line.
pub(super) fn first_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
