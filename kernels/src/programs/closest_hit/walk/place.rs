//! Twin of `place.wgsl`: a ray of the kernel `walk` between two passes.

use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::programs::closest_hit::grid_lists::list_ended;
use crate::programs::closest_hit::states::{BACKGROUND, TRAV};
use crate::programs::closest_hit::tracing::Trace;
use crate::tables::state::Tag;

/// A ray's position between two passes.
pub(super) struct Place<R: Real> {
    pub(super) tag: Tag,
    pub(super) cell: u32,
    pub(super) item: u32,
    pub(super) trace: Trace<R>,
}

impl<R: Real> Place<R> {
    /// The item of its list at which the ray waited; 0 if rays never wait.
    pub(super) fn waiting_item(&self, features: &Features) -> u32 {
        if features.resumes { self.item } else { 0 }
    }

    /// The state after a cell's list has ended; `exit` is the t at which the ray leaves the cell.
    pub(super) fn after_list(&self, features: &Features, exit: R) -> Tag {
        let tag = list_ended(features, self.trace.listed_as(features), self.trace.latest(), exit);
        let has_end = features.intervals && !features.in_cell;
        if has_end && tag == TRAV && self.trace.interval[1] <= exit { BACKGROUND } else { tag }
    }
}
