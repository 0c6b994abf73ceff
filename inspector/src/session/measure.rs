//! Measuring choices: which structure, schedule and rules a view of a scene should be traced with.

use std::sync::Arc;

use raystep_kernels::GridSize;
use raystep_lab::report::Answer;
use raystep_lab::reporter::Reporter;
use raystep_lab::subject::Subject;

use crate::settings::DeviceKind;

/// What to measure.
pub struct Measurement {
    /// The scene and the view.
    pub subject: Subject,
    /// Width and height of the view; only their ratio counts.
    pub size: [u32; 2],
    /// The grid's resolution where it is not varied.
    pub grid: GridSize,
    /// Fewer rays and repeats.
    pub is_quick: bool,
    /// Where passes run.
    pub device: DeviceKind,
}

/// Measures on a device of its own; the error is one line. It blocks, so only an engine in a thread of its own may have
/// one.
pub type Measure = Arc<dyn Fn(Measurement, &dyn Reporter) -> Result<Answer, String> + Send + Sync>;
