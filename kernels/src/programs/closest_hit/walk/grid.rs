//! Twin of `grid.wgsl`: through a uniform grid.

use super::place::Place;
use crate::numbers::real::Real;
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::streams::of_walk;
use crate::scene_data::SceneData;
use crate::shared::constants::INF;
use crate::shared::grid_walk::{GridRay, Walk};
use crate::shared::vector::smallest3;
use crate::tables::texels::Texels;

/// robust: tmax is computed from the cell each time, so there is nothing to keep.
fn kept_walk<R: Real>(ray: &Texels<'_, R>, index: u32, grid_ray: &GridRay<R>, scene: &SceneData) -> Walk<R> {
    let (grid, features) = (&scene.grid, &scene.features);
    let cell = grid.cell_of_index(index);
    let per_axis =
        if features.keeps_no_tmax() { grid.cell_exit(cell, grid_ray) } else { ray.load_vec3(of_walk(features)) };
    Walk { cell, per_axis, inside: true }
}

pub(super) fn walk<R: Real>(place: &mut Place<R>, ray: &mut Texels<'_, R>, scene: &SceneData) {
    let (grid, features) = (&scene.grid, &scene.features);
    let rules = features.walk_rules();
    let grid_ray = grid.ray(rules, place.trace.origin, place.trace.direction);
    let mut walk = kept_walk(ray, place.cell, &grid_ray, scene);
    let mut waits = false;
    for _ in 0..scene.info.steps {
        if place.trace.is_spent(scene) {
            break;
        }
        place.trace.turns += 1;
        let distance = scene.empty_distance(place.cell);
        if distance == 0 {
            let first = scene.grid_cells[place.cell as usize];
            let end = scene.grid_cells[place.cell as usize + 1];
            for item in first + place.waiting_item(features)..end {
                place.trace.test(scene, scene.grid_items[item as usize], walk.cell);
                if place.trace.ended {
                    place.tag = SHADE;
                    return;
                }
                if place.trace.is_spent(scene) && item + 1 < end {
                    place.item = item + 1 - first;
                    waits = true;
                    break;
                }
            }
        }
        let tag = place.trace.listed_as(features);
        if waits {
            place.tag = tag;
            break;
        }
        place.item = 0;
        let exit = if features.in_cell { R::from_f32(INF) } else { smallest3(walk.per_axis) };
        place.tag = place.after_list(features, exit);
        if place.tag != TRAV {
            break;
        }
        walk = grid.next_cell(rules, walk, distance, &grid_ray);
        if !walk.inside {
            place.tag = if tag == ISECT_NO_HIT { BACKGROUND } else { SHADE };
            break;
        }
        place.tag = tag;
        place.cell = grid.cell_index(walk.cell);
        place.trace.cells += 1;
    }
    if !features.keeps_no_tmax() {
        ray.store_vec3(of_walk(features), walk.per_axis);
    }
}
