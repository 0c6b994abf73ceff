//! Twin of `ordered.wgsl`: which of two hits a ray keeps, by exact t.

use super::tracing::Trace;
use crate::numbers::real::{Real, Vec3};
use crate::options::features::Features;
use crate::scene_data::SceneData;
use crate::shared::constants::{NO_TRIANGLE, TURNS_TO_CROSS, TURNS_TO_DECIDE};
use crate::shared::exact::{compare_exactly, meets_exactly, rounds_between};
use crate::shared::triangle::{Candidate, TriangleRules, hit_triangle, is_nearer};

impl<R: Real> Trace<R> {
    pub(super) fn accept(&mut self, features: &Features, candidate: &Candidate<R>, id: u32) {
        (self.t, self.error) = (candidate.t, candidate.error);
        (self.u, self.v, self.triangle) = (candidate.u, candidate.v, id);
        self.ended = self.is_any(features);
    }

    /// Keeps the nearest hit, as far as the bounds on errors tell which one it is.
    pub(super) fn order(&mut self, scene: &SceneData, candidate: &Candidate<R>, id: u32, corners: [Vec3<R>; 3]) {
        let (earliest, latest) = (candidate.t - candidate.error, candidate.t + candidate.error);
        if earliest > self.latest() || id == self.triangle {
            return;
        }
        let overlaps = latest >= self.t - self.error;
        if self.decides && (!candidate.is_sure || overlaps) {
            let (is_kept, turns) = match scene.features.all_hits {
                true => (self.crosses_next(scene, candidate, id, corners), TURNS_TO_CROSS),
                false => (self.is_nearer_exactly(scene, candidate, id, corners), TURNS_TO_DECIDE),
            };
            if is_kept {
                self.accept(&scene.features, candidate, id);
            }
            self.turns += turns;
        } else if candidate.is_sure && latest < self.latest() {
            if overlaps {
                self.open = self.open.min(self.t - self.error);
            }
            self.accept(&scene.features, candidate, id);
        } else {
            self.open = self.open.min(earliest);
        }
    }

    /// Whether the ray meets the triangle before its nearest hit so far, or at the same t and the triangle has the smaller id;
    /// before its end, if any hit ends it.
    #[cold]
    fn is_nearer_exactly(&self, scene: &SceneData, candidate: &Candidate<R>, id: u32, corners: [Vec3<R>; 3]) -> bool {
        let features = &scene.features;
        let any = self.is_any(features);
        if R::UNIT_ROUNDOFF != f32::UNIT_ROUNDOFF {
            // A ray in f64 is none that integers here can hold.
            let rules = TriangleRules { exact_order: false, ..features.triangle_rules() };
            let mut candidate = hit_triangle(rules, self.origin, self.direction, &self.shear, corners);
            if features.intervals {
                candidate = candidate.between(rules, self.interval);
            }
            return candidate.is_hit && is_nearer(candidate.t, id, self.t, self.triangle);
        }
        let rounded = |point: Vec3<R>| point.to_f64().map(|v| v as f32);
        let (o, d, corners) = (rounded(self.origin), rounded(self.direction), corners.map(rounded));
        if !candidate.is_sure && !meets_exactly(o, d, corners) {
            return false;
        }
        let to_f32 = |t: R| t.to_f64() as f32;
        if features.intervals && !candidate.is_sure && !rounds_between(self.interval.map(to_f32), o, d, corners) {
            return false;
        }
        let is_before = candidate.t + candidate.error < self.t - self.error;
        if any {
            return is_before || rounds_between([0.0, to_f32(self.t)], o, d, corners);
        }
        if is_before || self.triangle == NO_TRIANGLE {
            return true;
        }
        let kept = scene.corners::<R>(self.triangle).map(rounded);
        compare_exactly(o, d, corners, kept).then(id.cmp(&self.triangle)).is_lt()
    }
}
