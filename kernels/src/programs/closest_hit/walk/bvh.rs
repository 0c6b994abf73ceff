//! Twin of `bvh.wgsl`: through a binary BVH.

use super::place::Place;
use crate::numbers::real::Real;
use crate::programs::closest_hit::states::SHADE;
use crate::programs::closest_hit::streams::PREVIOUS;
use crate::scene_data::SceneData;
use crate::shared::bvh_walk::{TreeRay, Visit, next_node};
use crate::shared::constants::{NO_NODE, NODES_A_STEP};
use crate::tables::texels::Texels;

pub(super) fn walk<R: Real>(place: &mut Place<R>, ray: &mut Texels<'_, R>, scene: &SceneData) {
    let features = &scene.features;
    let tree_ray = TreeRay::new(place.trace.origin, place.trace.direction, features.ray_padding);
    let mut at = Visit { node: place.cell, previous: ray.load_u32(PREVIOUS, 0), in_leaf: false };
    let mut step = 0;
    let mut waits = false;
    while step < NODES_A_STEP * scene.info.steps && at.node != NO_NODE {
        if place.trace.is_spent(scene) {
            break;
        }
        place.trace.turns += 1;
        // A ray that waits at an item is already in its leaf.
        at.in_leaf = place.waiting_item(features) > 0;
        if !at.in_leaf {
            at = next_node(&scene.bvh_nodes, &scene.bvh_parents, at, &tree_ray, place.trace.farthest());
            place.trace.cells += 1;
        }
        if at.in_leaf {
            let (first, count) = scene.list(at.node);
            for item in first + place.waiting_item(features)..first + count {
                place.trace.test(scene, item, [0; 3]);
                if place.trace.ended {
                    place.tag = SHADE;
                    return;
                }
                if place.trace.is_spent(scene) && item + 1 < first + count {
                    place.item = item + 1 - first;
                    waits = true;
                    break;
                }
            }
        }
        if waits {
            break;
        }
        place.item = 0;
        step += 1;
    }
    if at.node == NO_NODE {
        place.tag = place.trace.ended_as();
    } else {
        place.cell = at.node;
        ray.store_u32(PREVIOUS, 0, at.previous);
    }
}
