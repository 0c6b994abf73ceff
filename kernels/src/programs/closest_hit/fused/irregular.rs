//! Twin of `irregular.wgsl`: through an irregular grid.

use super::waiting::Wait;
use crate::numbers::real::Real;
use crate::programs::closest_hit::ray::{load_voxel, store_voxel};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::irregular_walk::VoxelWalk;
use crate::shared::vector::smallest3;
use crate::tables::texels::Texels;

pub(super) fn trace<R: Real>(trace: &mut Trace<R>, wait: &mut Wait, ray: &mut Texels<'_, R>, scene: &SceneData) {
    let irregular = scene.irregular();
    let rules = scene.features.walk_rules();
    let grid_ray = scene.grid.ray(rules, trace.origin, trace.direction);
    // The first cell, or the one at which the ray waits.
    let mut walk = match wait.before {
        true => VoxelWalk { voxel: load_voxel(ray), cell: wait.cell, inside: true },
        false => irregular.enter(rules, &grid_ray),
    };
    let mut item = wait.item;
    trace.cells += u32::from(walk.inside && !wait.before);
    while walk.inside {
        let (first, count) = scene.list(walk.cell);
        if item < count {
            trace.test(scene, scene.listed(first + item), [0; 3]);
            if trace.ended {
                return;
            }
            item += 1;
        }
        if item == count {
            let exit = irregular.exit(&walk, &grid_ray);
            if trace.farthest() <= smallest3(exit) {
                return;
            }
            walk = irregular.step(&walk, exit, &grid_ray);
            item = 0;
            trace.cells += u32::from(walk.inside);
            trace.turns += 1 + scene.grid.levels;
        }
        if trace.is_spent(scene) && walk.inside {
            store_voxel(ray, walk.voxel);
            wait.at(walk.cell, item);
            return;
        }
    }
}
