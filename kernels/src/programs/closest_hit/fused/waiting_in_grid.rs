//! Twin of `waiting_in_grid.wgsl`: a ray in the grid between two dispatches of the fused kernel.

use super::waiting::Wait;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::streams::PLACE;
use crate::scene_data::SceneData;
use crate::shared::grid_walk::{GridRay, Walk};
use crate::tables::texels::Texels;

/// The first cell, or the one at which the ray waits.
pub(super) fn first_cell<R: Real>(
    wait: &Wait,
    ray: &Texels<'_, R>,
    grid_ray: &GridRay<R>,
    scene: &SceneData,
) -> Walk<R> {
    let (grid, features) = (&scene.grid, &scene.features);
    if !wait.before {
        return grid.enter(features.walk_rules(), grid_ray);
    }
    if features.keeps_no_tmax() {
        let cell = grid.cell_of_index(wait.cell);
        return Walk { cell, per_axis: grid.cell_exit(cell, grid_ray), inside: true };
    }
    let cell = [0, 1, 2].map(|layer| ray.load_u32(PLACE, layer) as i32);
    let [x, y, z] = [4, 5, 6].map(|layer| ray.load(PLACE, layer));
    Walk { cell, per_axis: Vec3::new(x, y, z), inside: true }
}

/// How many more cells the ray may visit. robust leaves the grid long before; with the paper's rules a ray may wrap over
/// a face again and again.
pub(super) fn cells_left<R: Real>(wait: &Wait, ray: &Texels<'_, R>, scene: &SceneData) -> i32 {
    match scene.features.in_cell {
        true if wait.before && !scene.features.keeps_no_tmax() => ray.load_u32(PLACE, 3) as i32,
        true => 4 * scene.grid.cells.iter().sum::<i32>() + 64,
        false => 0,
    }
}

/// Stores what cannot be computed from the cell's index: the coordinates if a ray wrapped over a face with the paper's
/// rules, tmax if it is accumulated or control terms, and how many more cells are allowed.
fn keep_place<R: Real>(ray: &mut Texels<'_, R>, walk: &Walk<R>, left: i32) {
    for (layer, cell) in walk.cell.into_iter().enumerate() {
        ray.store_u32(PLACE, layer, cell as u32);
    }
    ray.store_u32(PLACE, 3, left as u32);
    for (layer, value) in (4..).zip(walk.per_axis.to_array()) {
        ray.store(PLACE, layer, value);
    }
}

/// Waits at an item of a cell's list.
pub(super) fn wait_in<R: Real>(
    wait: &mut Wait,
    ray: &mut Texels<'_, R>,
    scene: &SceneData,
    walk: &Walk<R>,
    left: i32,
    (cell, item): (u32, u32),
) {
    if !scene.features.keeps_no_tmax() {
        keep_place(ray, walk, left);
    }
    wait.at(cell, item);
}
