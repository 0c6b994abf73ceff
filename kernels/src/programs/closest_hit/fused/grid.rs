//! Twin of `grid.wgsl`: through a uniform grid.

use super::waiting::Wait;
use super::waiting_in_grid::{cells_left, first_cell, wait_in};
use crate::numbers::real::Real;
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::vector::smallest3;
use crate::tables::texels::Texels;

pub(super) fn trace<R: Real>(trace: &mut Trace<R>, wait: &mut Wait, ray: &mut Texels<'_, R>, scene: &SceneData) {
    let (grid, features) = (&scene.grid, &scene.features);
    let rules = features.walk_rules();
    let grid_ray = grid.ray(rules, trace.origin, trace.direction);
    let mut walk = first_cell(wait, ray, &grid_ray, scene);
    let mut left = cells_left(wait, ray, scene);
    while walk.inside {
        let index = grid.cell_index(walk.cell);
        if trace.is_spent(scene) {
            wait_in(wait, ray, scene, &walk, left, (index, 0));
            return;
        }
        trace.turns += 1;
        trace.cells += u32::from(wait.item == 0);
        let distance = scene.empty_distance(index);
        if distance == 0 {
            let first = scene.grid_cells[index as usize];
            let end = scene.grid_cells[index as usize + 1];
            for item in first + wait.item..end {
                trace.test(scene, scene.grid_items[item as usize], walk.cell);
                if trace.ended {
                    return;
                }
                if trace.is_spent(scene) && item + 1 < end {
                    wait_in(wait, ray, scene, &walk, left, (index, item + 1 - first));
                    return;
                }
            }
        }
        wait.item = 0;
        if !features.in_cell {
            if trace.farthest() <= smallest3(walk.per_axis) {
                return;
            }
        } else {
            left -= 1;
            if trace.triangle != NO_TRIANGLE || left < 0 {
                return;
            }
        }
        walk = grid.next_cell(rules, walk, distance, &grid_ray);
    }
}
