//! Twin of `tracing.wgsl`: the variables of a ray in a kernel that takes several steps.

use crate::numbers::real::{Real, Vec3};
use crate::options::features::Features;
use crate::programs::closest_hit::states::{BACKGROUND, EXACT, ISECT_HIT, ISECT_NO_HIT, SHADE};
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::triangle::Shear;
use crate::tables::state::Tag;

/// The ray, its nearest hit so far, and counters.
pub(crate) struct Trace<R> {
    pub(crate) origin: Vec3<R>,
    pub(crate) direction: Vec3<R>,
    /// Hits count between these t.
    pub(crate) interval: [R; 2],
    pub(super) shear: Shear<R>,
    pub(crate) t: R,
    /// A bound on the error of t, if hits have an exact order; else 0.
    pub(crate) error: R,
    /// The smallest t at which there may be another hit, which only integers can tell.
    pub(crate) open: R,
    /// Integers are asked at once.
    pub(crate) decides: bool,
    pub(crate) u: R,
    pub(crate) v: R,
    pub(crate) triangle: u32,
    pub(crate) cells: u32,
    pub(crate) tests: u32,
    /// The triangle that the ray leaves.
    pub(super) leaves: u32,
    /// Between which t the hit on it lies, if all hits are wanted.
    pub(super) last: [R; 2],
    /// It ends at any hit, in a kernel that traces others too.
    pub(crate) is_shadow: bool,
    /// Any hit was requested, and one was found.
    pub(crate) ended: bool,
    /// Loop iterations in this dispatch so far.
    pub(crate) turns: u32,
}

impl<R: Real> Trace<R> {
    /// No hit so far; hits at `t` or beyond do not count, nor do those outside of `interval` or of the triangle `leaves`.
    pub(crate) fn new(origin: Vec3<R>, direction: Vec3<R>, interval: [R; 2], leaves: u32, t: R) -> Self {
        Self {
            origin,
            direction,
            interval,
            leaves,
            last: [R::zero(); 2],
            shear: Shear::of(direction),
            t,
            error: R::zero(),
            open: R::from_f32(INF),
            decides: false,
            u: R::zero(),
            v: R::zero(),
            triangle: NO_TRIANGLE,
            cells: 0,
            tests: 0,
            is_shadow: false,
            ended: false,
            turns: 0,
        }
    }

    /// Whether any hit ends the ray.
    pub(super) fn is_any(&self, features: &Features) -> bool {
        if features.whole_paths { self.is_shadow } else { features.any_hit }
    }

    /// The state of a ray whose walk is over.
    pub(crate) fn ended_as(&self) -> Tag {
        if self.is_open() {
            EXACT
        } else if self.triangle == NO_TRIANGLE {
            BACKGROUND
        } else {
            SHADE
        }
    }

    /// The state of a ray in a list.
    pub(crate) fn listed_as(&self, features: &Features) -> Tag {
        if features.any_hit || self.triangle == NO_TRIANGLE { ISECT_NO_HIT } else { ISECT_HIT }
    }

    /// The largest t that the nearest hit may have.
    pub(crate) fn latest(&self) -> R {
        self.t + self.error
    }

    /// Whether only integers can tell what is hit.
    pub(crate) fn is_open(&self) -> bool {
        !self.ended && self.open <= self.latest() && self.open < R::from_f32(INF)
    }

    /// No box or cell behind this t has a hit that is wanted.
    pub(crate) fn farthest(&self) -> R {
        self.latest().min(self.interval[1])
    }

    /// Whether the rest is left to the next dispatch.
    pub(crate) fn is_spent(&self, scene: &SceneData) -> bool {
        scene.features.resumes && self.turns >= scene.features.turns
    }
}
