//! Twin of `waiting.wgsl`: a ray of the fused kernel between two dispatches.

use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::programs::closest_hit::states::{EXACT, ISECT_HIT, ISECT_NO_HIT, TRAV, TRAV_SETUP, UNWRITTEN};
use crate::programs::closest_hit::streams::{BOUNDS, STATE};
use crate::programs::closest_hit::tracing::Trace;
use crate::shared::constants::INF;
use crate::tables::state::Tag;
use crate::tables::texels::Texels;

/// In the place of the smallest open t of a ray that waits for integers to go on.
pub(super) const WAITS: f32 = -1.0;

/// Where a ray waits; all zeros if it does not.
#[derive(Default)]
pub(super) struct Wait {
    /// Whether it waited before this dispatch.
    pub(super) before: bool,
    /// Whether it waits after it.
    pub(super) after: bool,
    /// As in the stream `state`: the cell and the item in its list, or the node and its level, or the triangle.
    pub(super) cell: u32,
    pub(super) item: u32,
}

impl Wait {
    /// Whether the ray is new, or waits.
    pub(super) fn has_work<R: Real>(&mut self, ray: &mut Texels<'_, R>, features: &Features) -> bool {
        let tag = ray.load_u32(STATE, 0);
        if features.decides {
            self.before = features.resumes && tag == EXACT && ray.load(BOUNDS, 1) == R::from_f32(WAITS);
            if self.before {
                ray.store(BOUNDS, 1, R::from_f32(INF));
            }
            return tag == EXACT;
        }
        let is_new = tag == if features.eye_rays { UNWRITTEN } else { TRAV_SETUP };
        self.before = features.resumes && (tag == TRAV || tag == ISECT_NO_HIT || tag == ISECT_HIT);
        is_new || self.before
    }

    pub(super) fn at(&mut self, cell: u32, item: u32) {
        (self.after, self.cell, self.item) = (true, cell, item);
    }

    /// The state of a ray that waits.
    pub(super) fn waits_as<R: Real>(&self, trace: &Trace<R>, features: &Features) -> Tag {
        if features.decides {
            EXACT
        } else if features.bvh {
            TRAV
        } else {
            trace.listed_as(features)
        }
    }
}
