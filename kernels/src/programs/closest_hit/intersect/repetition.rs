//! Twin of `repetition.wgsl`: whether an earlier cell of the grid listed a triangle too.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::streams::SCAN;
use crate::scene_data::SceneData;
use crate::shared::constants::NO_CELL;
use crate::shared::grid_walk::Walk;
use crate::tables::texels::Texels;

/// Whether a cell lists a triangle; lists are in ascending order.
fn is_listed(scene: &SceneData, triangle: u32, cell: u32) -> bool {
    let (first, end) = (scene.grid_cells[cell as usize], scene.grid_cells[cell as usize + 1]);
    scene.grid_items[first as usize..end as usize].binary_search(&triangle).is_ok()
}

/// Stores the position of the search for the next dispatch.
fn keep_scan<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData, cell: u32, per_axis: Vec3<R>) {
    if scene.features.resumes_scan {
        ray.store_u32(SCAN, 0, cell);
        for (layer, value) in (1..).zip(per_axis.to_array()) {
            ray.store(SCAN, layer, value);
        }
    }
}

/// Repeats the walk from its start, and looks into every list. `None` if the search continues in the next dispatch.
pub(super) fn repetition<R: Real>(
    ray: &mut Texels<'_, R>,
    scene: &SceneData,
    triangle: u32,
    cell: u32,
    (origin, direction): (Vec3<R>, Vec3<R>),
) -> Option<bool> {
    let (grid, features) = (&scene.grid, &scene.features);
    let rules = features.walk_rules();
    let ray_in_grid = grid.ray(rules, origin, direction);
    let mut walk = grid.enter(rules, &ray_in_grid);
    let bound = grid.cells[0] + grid.cells[1] + grid.cells[2] + 2;
    let mut turns = 0;
    if features.resumes_scan {
        let begun = ray.load_u32(SCAN, 0);
        if begun != NO_CELL {
            let [x, y, z] = [1, 2, 3].map(|layer| ray.load(SCAN, layer));
            walk = Walk { cell: grid.cell_of_index(begun), per_axis: Vec3::new(x, y, z), inside: true };
        }
    }
    let mut step = 0;
    while step < bound && walk.inside {
        let index = grid.cell_index(walk.cell);
        if index == cell {
            break;
        }
        if features.resumes_scan && turns >= features.turns {
            keep_scan(ray, scene, index, walk.per_axis);
            return None;
        }
        // One iteration for the cell, and at most the bit length of its list for the binary search.
        turns += 1 + 32 - scene.list(index).1.leading_zeros();
        if is_listed(scene, triangle, index) {
            keep_scan(ray, scene, NO_CELL, Vec3::splat(R::zero()));
            return Some(true);
        }
        walk = grid.advance(rules, walk, &ray_in_grid);
        step += 1;
    }
    keep_scan(ray, scene, NO_CELL, Vec3::splat(R::zero()));
    Some(false)
}
