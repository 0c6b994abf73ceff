//! Errors of measurements.

use raystep_kernels::interpret::InterpretError;
use raystep_kernels::{GpuError, PlanError, RenderError};
use raystep_scenes::generate::GenerateError;

/// A measurement that failed, or could not be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scene could not be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A run failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A kernel cannot be interpreted.
    #[error(transparent)]
    Interpret(#[from] InterpretError),
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A scene could not be generated.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// A camera has no view.
    #[error("the case's camera has no direction")]
    NoView,
    /// An extreme case failed.
    #[error("{name}: {error}")]
    Case {
        /// The case.
        name: &'static str,
        /// Why.
        error: Box<Error>,
    },
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] std::io::Error),
    /// No configuration could be built.
    #[error("nothing was built")]
    NothingBuilt,
    /// The configurations of a comparison are kept in memory together.
    #[error(
        "the configurations take more than {} MiB together: compare fewer sizes, kinds of rays, structures or schedules \
         at a time",
        most >> 20
    )]
    TooLargeTogether {
        /// Most bytes.
        most: u64,
    },
    /// The reporter asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// A run took longer than it may.
    #[error("stopped: too slow, or endless")]
    GivenUp,
    /// There was no time left for it.
    #[error("the time was over")]
    TimeOver,
    /// No scene has a ray of the kinds that were asked for.
    #[error("nothing to measure: no pixel has a ray of the requested kinds")]
    NoRays,
    /// A picture could not be encoded.
    #[error("cannot encode a picture: {0}")]
    Picture(#[from] image::ImageError),
}
