//! The triangles that a walk tests.

use std::collections::BTreeMap;

use glam::DVec3;
use raystep_kernels::export::trace::{RayState, TraceRow};
use raystep_kernels::named;
use raystep_kernels::numbers::real::Vec3;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::triangle::{Shear, hit_triangle, plane_hit};

use super::why::Why;
use super::{Structure, WalkGeometry, corners};

/// The outcome of a test, the best last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// The ray misses the triangle.
    Missed,
    /// A hit, but not the nearest so far, or one that this cell must not accept.
    NotNearest,
    /// The nearest hit so far.
    Nearest,
}

named!(Outcome, Missed "missed", NotNearest "hit, not the nearest", Nearest "hit");

impl Outcome {
    /// Whether the ray meets the triangle.
    #[must_use]
    pub fn is_hit(self) -> bool {
        self != Self::Missed
    }
}

/// A test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestedTriangle {
    /// The row of the test.
    pub row: usize,
    /// The triangle.
    pub triangle: u32,
    /// Its corners.
    pub corners: [DVec3; 3],
    /// Index of the cell or node visit that lists it; `None` without a structure.
    pub visit: Option<usize>,
    /// The outcome.
    pub outcome: Outcome,
    /// Why it was accepted or not.
    pub why: Why,
    /// Where the ray meets the triangle's plane; `None` if it does not.
    pub t: Option<f64>,
    /// Weights of vertices 1 and 2 there.
    pub barycentric: Option<[f64; 2]>,
}

impl WalkGeometry {
    /// Indices into [`tested`](Self::tested) with each triangle once, in order of id; of several tests of one, the
    /// first with the best outcome.
    #[must_use]
    pub fn distinct_tested(&self) -> Vec<usize> {
        let mut best = BTreeMap::new();
        for (i, tested) in self.tested.iter().enumerate() {
            let entry = best.entry(tested.triangle).or_insert((tested.outcome, i));
            if tested.outcome > entry.0 {
                *entry = (tested.outcome, i);
            }
        }
        best.into_values().map(|(_, i)| i).collect()
    }

    /// Processes a row that may test a triangle.
    pub(super) fn test_triangle(&mut self, data: &SceneData, i: usize, row: &TraceRow, before: Option<&RayState>) {
        let Some((triangle, at)) = row.tested.and_then(|triangle| Some((triangle, corners(data, triangle)?))) else {
            return;
        };
        let after = &row.after;
        let [origin, direction] = [after.origin, after.direction].map(Vec3::<f32>::from_f32);
        let (rules, shear) = (data.features.triangle_rules(), Shear::of(direction));
        let vertices = data.corners(triangle);
        let mut candidate = hit_triangle::<f32>(rules, origin, direction, &shear, vertices);
        let is_hit = candidate.is_hit;
        if rules.watertight && !is_hit {
            candidate = plane_hit(origin, &shear, vertices);
        }
        let is_new = before.is_none_or(|b| b.triangle != after.triangle || b.t != after.t);
        let outcome = match (after.triangle == Some(triangle) && is_new, is_hit) {
            (true, _) => Outcome::Nearest,
            (false, true) => Outcome::NotNearest,
            (false, false) => Outcome::Missed,
        };
        let why = match outcome {
            Outcome::Nearest => Why::Accepted,
            Outcome::NotNearest => Why::refused(data, before, triangle, candidate.t),
            Outcome::Missed => Why::missed([candidate.u, candidate.v], candidate.t),
        };
        // The device's own values if it stored them.
        let (t, barycentric) = match (outcome, after.t, after.barycentric) {
            (Outcome::Nearest, Some(t), Some(barycentric)) => (t, barycentric),
            _ => (candidate.t, [candidate.u, candidate.v]),
        };
        let visit = match self.structure {
            Structure::Grid => self.cells.len().checked_sub(1),
            Structure::Tree => self.nodes.iter().rposition(|node| node.is_leaf && node.is_met),
            Structure::Nothing => None,
        };
        self.tested.push(TestedTriangle {
            row: i,
            triangle,
            corners: at,
            visit,
            outcome,
            why,
            t: t.is_finite().then_some(f64::from(t)),
            barycentric: barycentric.iter().all(|w| w.is_finite()).then(|| barycentric.map(f64::from)),
        });
    }
}
