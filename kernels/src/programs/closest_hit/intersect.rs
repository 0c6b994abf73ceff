//! Twin of `intersect.wgsl`: tests the ray against one triangle of its list.

use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::grid_lists::list_ended;
use crate::programs::closest_hit::ray::{load_direction, load_interval, load_origin};
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::streams::{COUNTERS, HIT, SCAN, STATE, TMAX};
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_CELL};
use crate::shared::grid_walk::Walk;
use crate::shared::triangle::{Shear, hit_triangle, is_nearer};
use crate::shared::vector::smallest3;
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

/// Whether an earlier cell listed the triangle too: walks again from the start. `None` if the search continues in the
/// next dispatch.
fn repetition<R: Real>(
    texels: &mut Texels<'_, R>,
    scene: &SceneData,
    triangle: u32,
    cell: u32,
    origin: Vec3<R>,
    direction: Vec3<R>,
) -> Option<bool> {
    let (grid, features) = (&scene.grid, &scene.features);
    let rules = features.walk_rules();
    let ray = grid.ray(rules, origin, direction);
    let mut walk = grid.enter(rules, &ray);
    let bound = grid.cells[0] + grid.cells[1] + grid.cells[2] + 2;
    let mut turns = 0;
    if features.resumes_scan {
        let begun = texels.load_u32(SCAN, 0);
        if begun != NO_CELL {
            let [x, y, z] = [1, 2, 3].map(|layer| texels.load(SCAN, layer));
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
            keep_scan(texels, scene, index, walk.per_axis);
            return None;
        }
        // One iteration for the cell, and at most the bit length of its list for the binary search.
        turns += 1 + 32 - scene.list(index).1.leading_zeros();
        if is_listed(scene, triangle, index) {
            keep_scan(texels, scene, NO_CELL, Vec3::splat(R::zero()));
            return Some(true);
        }
        walk = grid.advance(rules, walk, &ray);
        step += 1;
    }
    keep_scan(texels, scene, NO_CELL, Vec3::splat(R::zero()));
    Some(false)
}

/// Processes one ray.
pub fn intersect<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let mut tag = ray.load_u32(STATE, 0);
    if tag != ISECT_NO_HIT && tag != ISECT_HIT {
        return;
    }
    let features = &scene.features;

    let nearest_before: R = ray.load(STATE, 1);
    let mut nearest_t = nearest_before;
    let cell = ray.load_u32(STATE, 2);
    let mut item = ray.load_u32(STATE, 3);
    let (first, count) = scene.list(cell);

    let origin = load_origin(ray);
    let direction = load_direction(ray);
    let in_list = item < count;
    if in_list {
        let triangle = scene.listed(first + item);
        let mut repeated = false;
        if features.grid && features.counters {
            match repetition(ray, scene, triangle, cell, origin, direction) {
                Some(known) => repeated = known,
                None => return,
            }
        }
        let shear = Shear::of(direction);
        let candidate = hit_triangle(features.triangle_rules(), origin, direction, &shear, scene.corners(triangle));
        let candidate = if features.intervals { candidate.between(load_interval(ray, features)) } else { candidate };
        let accepted = if features.in_cell {
            candidate.t < nearest_t
                && scene.grid.is_in_cell(origin + direction * candidate.t, scene.grid.cell_of_index(cell))
        } else if features.robust && !features.any_hit {
            is_nearer(candidate.t, triangle, nearest_t, ray.load_u32(HIT, 2))
        } else {
            candidate.t < nearest_t
        };
        if candidate.is_hit && accepted {
            ray.store(HIT, 0, candidate.u);
            ray.store(HIT, 1, candidate.v);
            ray.store_u32(HIT, 2, triangle);
            nearest_t = candidate.t;
            tag = ISECT_HIT;
        }
        item += 1;
        if features.counters {
            ray.store_u32(COUNTERS, 1, ray.load_u32(COUNTERS, 1) + 1);
        }
        if features.grid && features.counters {
            ray.store_u32(COUNTERS, 2, ray.load_u32(COUNTERS, 2) + u32::from(repeated));
        }
    }

    let ended = if features.robust { item >= count } else { !in_list };
    if ended {
        tag = if features.grid || features.irregular {
            let exit = if !features.in_cell { smallest3(ray.load_vec3(TMAX)) } else { R::from_f32(INF) };
            match list_ended(features, tag, nearest_t, exit) {
                TRAV if features.intervals && !features.in_cell && load_interval(ray, features)[1] <= exit => {
                    BACKGROUND
                }
                next => next,
            }
        } else if features.bvh {
            TRAV
        } else if tag == ISECT_HIT {
            SHADE
        } else {
            BACKGROUND
        };
    }
    if nearest_t < nearest_before {
        if features.any_hit {
            tag = SHADE;
        }
        ray.store(STATE, 1, nearest_t);
    }
    ray.store_u32(STATE, 0, tag);
    ray.store_u32(STATE, 3, item);
}
