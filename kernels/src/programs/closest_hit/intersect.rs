//! Twin of `intersect.wgsl`: tests the ray against one triangle of its list. [`SceneData::list`] stands for the modules of
//! the structures.

mod acceptance;
mod cell_end;
mod repetition;

use crate::numbers::real::Real;
use crate::options::features::StructureKind;
use crate::programs::closest_hit::bounds::{ended_with, latest_of};
use crate::programs::closest_hit::later::{later, range_of};
use crate::programs::closest_hit::ray::{load_direction, load_interval, load_origin, load_surface};
use crate::programs::closest_hit::states::{BACKGROUND, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::streams::{COUNTERS, HIT, STATE};
use crate::scene_data::SceneData;
use crate::shared::triangle::{Shear, hit_triangle, is_nearer};
use crate::tables::state::Tag;
use crate::tables::texels::Texels;
use acceptance::is_kept;
use cell_end::after_cell;
use repetition::repetition;

/// The state after a list has ended.
fn after_list<R: Real>(ray: &Texels<'_, R>, scene: &SceneData, tag: Tag, nearest_t: R) -> Tag {
    match scene.features.structure() {
        StructureKind::Grid | StructureKind::Irregular => after_cell(ray, &scene.features, tag, nearest_t),
        // A later leaf may have a nearer hit.
        StructureKind::Bvh => TRAV,
        StructureKind::None if tag == ISECT_HIT => SHADE,
        StructureKind::None => BACKGROUND,
    }
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
    let (origin, direction) = (load_origin(ray), load_direction(ray));
    let in_list = item < count;
    if in_list {
        let triangle = scene.listed(first + item);
        let mut repeated = false;
        if features.grid && features.counters {
            match repetition(ray, scene, triangle, cell, (origin, direction)) {
                Some(known) => repeated = known,
                None => return,
            }
        }
        let shear = Shear::of(direction);
        let (rules, corners) = (features.triangle_rules(), scene.corners(triangle));
        let mut candidate = hit_triangle(rules, origin, direction, &shear, corners);
        if features.intervals {
            candidate = candidate.between(rules, load_interval(ray, features));
        }
        candidate.is_hit = candidate.is_hit && triangle != load_surface(ray, features);
        if features.all_hits {
            candidate = later(candidate, range_of(scene, [origin, direction], &shear, load_surface(ray, features)));
        }
        let accepted = if features.exact_order {
            is_kept(ray, scene, (origin, direction), &candidate, triangle, nearest_t)
        } else if features.in_cell {
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
        tag = after_list(ray, scene, tag, latest_of(ray, features, nearest_t));
        tag = ended_with(ray, features, tag, nearest_t);
    }
    if nearest_t != nearest_before {
        if features.any_hit {
            tag = SHADE;
        }
        ray.store(STATE, 1, nearest_t);
    }
    ray.store_u32(STATE, 0, tag);
    ray.store_u32(STATE, 3, item);
}
