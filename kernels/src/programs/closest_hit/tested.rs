//! Twin of `tested.wgsl`: the test of one triangle in a kernel that takes several steps.

use super::later::later;
use super::tracing::Trace;
use crate::numbers::real::Real;
use crate::scene_data::SceneData;
use crate::shared::constants::TURNS_A_TEST;
use crate::shared::packed_triangles::unpack;
use crate::shared::triangle::{hit_triangle, is_nearer};

impl<R: Real> Trace<R> {
    /// Tests one triangle; `cell` matters only if hits must lie in it.
    #[inline(always)]
    pub(crate) fn test(&mut self, scene: &SceneData, entry: u32, cell: [i32; 3]) {
        let features = &scene.features;
        let rules = features.triangle_rules();
        let (corners, id) = unpack(&scene.packed_triangles[entry as usize]);
        let mut candidate = hit_triangle(rules, self.origin, self.direction, &self.shear, corners);
        if features.intervals {
            candidate = candidate.between(rules, self.interval);
        }
        if features.all_hits {
            candidate = later(candidate, self.last);
        }
        self.tests += 1;
        self.turns += TURNS_A_TEST;
        if !candidate.is_hit || id == self.leaves {
            return;
        }
        if features.exact_order {
            return self.order(scene, &candidate, id, corners);
        }
        let accepted = if features.in_cell {
            candidate.t < self.t && scene.grid.is_in_cell(self.origin + self.direction * candidate.t, cell)
        } else if features.robust && !self.is_any(features) {
            is_nearer(candidate.t, id, self.t, self.triangle)
        } else {
            candidate.t < self.t
        };
        if accepted {
            self.accept(features, &candidate, id);
        }
    }
}
