//! What would need a kernel or a stream that a build does without. A plan calls a grid of two levels irregular, as the
//! kernels that trace rays through it do.

use crate::options::Accelerator;
use crate::options::reasons::{Because, Reason, Run};

/// The references are sorted by each digit of their cells, from one stream to another and back.
const DIGITS: Reason = (Because::Scene, "needed only if the cells have another number of digits to sort by");

/// For what every build may need.
pub(super) fn every(_: &Run<'_>) -> Reason {
    DIGITS
}

/// For grids whose lists are in the streams in which references are sorted.
pub(super) fn uniform(run: &Run<'_>) -> Reason {
    match run.accelerator {
        Accelerator::Irregular => (Because::Options, "needed only with --accelerator grid, if no cells are divided"),
        _ => DIGITS,
    }
}

/// For grids whose cells are divided.
pub(super) fn divided(run: &Run<'_>) -> Reason {
    match run.accelerator {
        Accelerator::Irregular => DIGITS,
        _ => (Because::Options, "needed only with --accelerator irregular, or a grid whose crowded cells are divided"),
    }
}

/// For grids whose cells are merged and expanded.
pub(super) fn irregular(_: &Run<'_>) -> Reason {
    (Because::Options, "needed only with --accelerator irregular")
}

/// For grids of two levels.
pub(super) fn two_levels(_: &Run<'_>) -> Reason {
    (Because::Options, "needed only with --accelerator grid, if crowded cells are divided")
}
