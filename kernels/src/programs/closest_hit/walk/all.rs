//! Twin of `all.wgsl`: without a structure.

use super::place::Place;
use crate::numbers::real::Real;
use crate::programs::closest_hit::states::SHADE;
use crate::scene_data::SceneData;

pub(super) fn walk<R: Real>(place: &mut Place<R>, scene: &SceneData) {
    let end = scene.info.triangles.min(place.item.saturating_add(scene.info.steps));
    while place.item < end {
        if place.trace.is_spent(scene) {
            break;
        }
        place.trace.test(scene, place.item, [0; 3]);
        if place.trace.ended {
            place.tag = SHADE;
            return;
        }
        place.item += 1;
    }
    if place.item >= scene.info.triangles {
        place.tag = place.trace.ended_as();
    }
}
