//! Errors of a run.

use crate::executor::TooMany;
use crate::executor::cpu::{CpuError, Failed, OutOfMemory};
#[cfg(feature = "gpu")]
use crate::executor::gpu::GpuError;
use crate::plan::PlanError;
use crate::tables::stream::Region;

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// It does not fit the device.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The GPU failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The system does not have enough memory for the twins' streams.
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
    /// The run found more elements than fit.
    #[error(transparent)]
    TooMany(#[from] TooMany),
    /// A user's kernel failed.
    #[error(transparent)]
    Failed(#[from] Failed),
    /// The caller's progress function asked to stop.
    #[error("cancelled after {passes} passes")]
    Cancelled {
        /// Number of passes that were complete.
        passes: usize,
    },
    /// A user's program does not end.
    #[error("the program has not ended after {passes} passes, {waiting}: check the conditions of its schedule's loops")]
    Endless {
        /// Number of passes.
        passes: u64,
        /// How many elements are in which states.
        waiting: String,
    },
    /// The stream is not part of the plan.
    #[error("stream {0:?} is omitted from this run's plan")]
    NoStream(&'static str),
    /// The program traces no rays.
    #[error("program {0} traces no rays: it has no image and no hits")]
    NoRays(&'static str),
    /// A set has no such element.
    #[error("this run has {count} {elements}, counted from 0: {index} is none of them")]
    NoElement {
        /// Name of the set.
        elements: &'static str,
        /// The element.
        index: u32,
        /// How many there are.
        count: u32,
    },
    /// The image has no such pixels.
    #[error("{}x{} pixels from {},{} are not in an image of {width}x{height}", region.width, region.height, region.x, region.y)]
    NoPixel {
        /// The requested region.
        region: Region,
        /// Columns of the image.
        width: u32,
        /// Rows of the image.
        height: u32,
    },
    /// The elements of the stream have not been counted yet.
    #[error("stream {stream:?} has no texels yet: {elements} are counted by a pass to come")]
    NotCounted {
        /// The stream's name.
        stream: &'static str,
        /// Name of the set.
        elements: &'static str,
    },
    /// The stream has no such layer.
    #[error("stream {stream:?} has no layer {layer}")]
    NoLayer {
        /// The stream's name.
        stream: &'static str,
        /// The requested layer.
        layer: usize,
    },
    /// The grid that the device has built is checked, and wrong. This is a bug in raystep or in the driver.
    #[error(
        "the grid that the device has built has {0} faults: a defect of raystep or of the driver; use --build host"
    )]
    Faulty(u64),
    /// The streams to take over belong to another plan or device.
    #[error("streams of another run do not fit this one")]
    OtherRun,
    /// A pass that was submitted ahead changed something. This is a bug in raystep.
    #[error("pass {0}, submitted ahead of its turn, was not idle")]
    Overshoot(usize),
}

impl From<CpuError> for RenderError {
    fn from(error: CpuError) -> Self {
        match error {
            CpuError::Memory(error) => Self::Memory(error),
            CpuError::TooMany(error) => Self::TooMany(error),
            CpuError::Failed(error) => Self::Failed(error),
        }
    }
}
