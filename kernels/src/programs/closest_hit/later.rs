//! Twin of `later.wgsl`: of a ray whose hits are all wanted, which hits come after the last.

use super::tracing::Trace;
use crate::numbers::real::{Real, Vec3};
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::crossing::{compare_crossings, crosses_exactly};
use crate::shared::exact::rounds_between;
use crate::shared::triangle::{Candidate, Shear, hit_triangle};

/// Between which t the last hit lies; before all others if there was none, or if not all hits are wanted.
pub(super) fn range_of<R: Real>(
    scene: &SceneData,
    [origin, direction]: [Vec3<R>; 2],
    shear: &Shear<R>,
    last: u32,
) -> [R; 2] {
    if last == NO_TRIANGLE || !scene.features.all_hits {
        return [-R::from_f32(INF); 2];
    }
    let hit = hit_triangle(scene.features.triangle_rules(), origin, direction, shear, scene.corners(last));
    [hit.t - hit.error, hit.t + hit.error]
}

/// The candidate, which is a hit only after the last one.
pub(super) fn later<R: Real>(found: Candidate<R>, [earliest, latest]: [R; 2]) -> Candidate<R> {
    Candidate {
        is_hit: found.is_hit && found.t + found.error >= earliest,
        is_sure: found.is_sure && found.t - found.error > latest,
        ..found
    }
}

impl<R: Real> Trace<R> {
    /// The same ray, which looks for what comes after the hit on the triangle that it leaves, if all hits are wanted.
    pub(super) fn after_last(self, scene: &SceneData) -> Self {
        let last = range_of(scene, [self.origin, self.direction], &self.shear, self.leaves);
        Self { last, ..self }
    }

    /// Whether the ray crosses the triangle, after the last hit and before its nearest one so far.
    pub(super) fn crosses_next(
        &self,
        scene: &SceneData,
        candidate: &Candidate<R>,
        id: u32,
        corners: [Vec3<R>; 3],
    ) -> bool {
        // Rays that are given have origins and directions in f32, and so have the corners.
        let rounded = |point: Vec3<R>| point.to_f64().map(|v| v as f32);
        let (o, d, corners) = (rounded(self.origin), rounded(self.direction), corners.map(rounded));
        // Of two in one plane, it is the one with the smaller id.
        let is_before = |other: u32| {
            let others = scene.corners::<R>(other).map(rounded);
            compare_crossings(o, d, corners, others).then(id.cmp(&other)).is_lt()
        };
        if !candidate.is_sure
            && (!crosses_exactly(o, d, corners) || (self.leaves != NO_TRIANGLE && is_before(self.leaves)))
        {
            return false;
        }
        let interval = self.interval.map(|end| end.to_f64() as f32);
        if scene.features.intervals && !candidate.is_sure && !rounds_between(interval, o, d, corners) {
            return false;
        }
        let is_surely_nearer = candidate.t + candidate.error < self.t - self.error;
        self.triangle == NO_TRIANGLE || is_surely_nearer || is_before(self.triangle)
    }
}
