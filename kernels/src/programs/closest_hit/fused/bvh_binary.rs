//! Twin of `bvh_binary.wgsl`: through a binary BVH.

use super::waiting::Wait;
use crate::numbers::real::Real;
use crate::programs::closest_hit::streams::PREVIOUS;
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::bvh_walk::{TreeRay, Visit, next_node};
use crate::shared::constants::NO_NODE;
use crate::tables::texels::Texels;

pub(super) fn trace<R: Real>(trace: &mut Trace<R>, wait: &mut Wait, ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tree_ray = TreeRay::new(trace.origin, trace.direction, scene.features.ray_padding);
    let root = if scene.info.triangles == 0 { NO_NODE } else { 0 };
    let mut at = Visit { node: root, previous: NO_NODE, in_leaf: false };
    if wait.before {
        at = Visit { node: wait.cell, previous: ray.load_u32(PREVIOUS, 0), in_leaf: false };
    }
    while at.node != NO_NODE {
        if trace.is_spent(scene) {
            ray.store_u32(PREVIOUS, 0, at.previous);
            wait.at(at.node, 0);
            return;
        }
        trace.turns += 1;
        // A ray that waits at an item is already in its leaf.
        at.in_leaf = wait.item > 0;
        if !at.in_leaf {
            at = next_node(&scene.bvh_nodes, &scene.bvh_parents, at, &tree_ray, trace.farthest());
            trace.cells += 1;
        }
        if at.in_leaf {
            let (first, count) = scene.list(at.node);
            for item in first + wait.item..first + count {
                trace.test(scene, item, [0; 3]);
                if trace.ended {
                    return;
                }
                if trace.is_spent(scene) && item + 1 < first + count {
                    ray.store_u32(PREVIOUS, 0, at.previous);
                    wait.at(at.node, item + 1 - first);
                    return;
                }
            }
        }
        wait.item = 0;
    }
}
