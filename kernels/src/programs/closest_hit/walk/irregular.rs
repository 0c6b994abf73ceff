//! Twin of `irregular.wgsl`: through an irregular grid.

use super::place::Place;
use crate::numbers::real::Real;
use crate::programs::closest_hit::ray::{load_voxel, store_voxel};
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_NO_HIT, SHADE, TRAV};
use crate::scene_data::SceneData;
use crate::shared::irregular_walk::VoxelWalk;
use crate::shared::vector::smallest3;
use crate::tables::texels::Texels;

pub(super) fn walk<R: Real>(place: &mut Place<R>, ray: &mut Texels<'_, R>, scene: &SceneData) {
    let (irregular, features) = (scene.irregular(), &scene.features);
    let grid_ray = scene.grid.ray(features.walk_rules(), place.trace.origin, place.trace.direction);
    let mut walk = VoxelWalk { voxel: load_voxel(ray), cell: place.cell, inside: true };
    let mut waits = false;
    for _ in 0..scene.info.steps {
        if place.trace.is_spent(scene) {
            break;
        }
        // One to find the next cell in each level of the map, at most.
        place.trace.turns += 1 + scene.grid.levels;
        let (first, count) = scene.list(place.cell);
        for item in first + place.waiting_item(features)..first + count {
            place.trace.test(scene, scene.listed(item), [0; 3]);
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
        let tag = place.trace.listed_as(features);
        if waits {
            place.tag = tag;
            break;
        }
        place.item = 0;
        let exit = irregular.exit(&walk, &grid_ray);
        place.tag = place.after_list(features, smallest3(exit));
        if place.tag != TRAV {
            break;
        }
        walk = irregular.step(&walk, exit, &grid_ray);
        if !walk.inside {
            place.tag = if tag == ISECT_NO_HIT { BACKGROUND } else { SHADE };
            break;
        }
        place.tag = tag;
        place.cell = walk.cell;
        place.trace.cells += 1;
    }
    store_voxel(ray, walk.voxel);
}
