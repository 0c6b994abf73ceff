//! Twin of `all.wgsl`: through all triangles.

use super::waiting::Wait;
use crate::numbers::real::Real;
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;

pub(super) fn trace<R: Real>(trace: &mut Trace<R>, wait: &mut Wait, scene: &SceneData) {
    for triangle in wait.item..scene.info.triangles {
        trace.test(scene, triangle, [0; 3]);
        if trace.ended {
            return;
        }
        if trace.is_spent(scene) && triangle + 1 < scene.info.triangles {
            wait.at(0, triangle + 1);
            return;
        }
    }
}
