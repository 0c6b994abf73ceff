//! Twin of `walk.wgsl`: advances each ray by up to K steps. The loop over the steps is in the module of the structure.

mod all;
mod bvh;
mod grid;
mod irregular;
mod place;

use crate::numbers::real::Real;
use crate::options::features::StructureKind;
use crate::programs::closest_hit::ray::{load_direction, load_interval, load_origin, load_surface};
use crate::programs::closest_hit::states::{BACKGROUND, EXACT, ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::streams::{BOUNDS, COUNTERS, HIT, STATE};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::tables::texels::Texels;
use place::Place;

/// Processes one ray.
pub fn walk<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let tag = ray.load_u32(STATE, 0);
    if tag != TRAV && tag != ISECT_NO_HIT && tag != ISECT_HIT {
        return;
    }
    let features = &scene.features;
    let interval = load_interval(ray, features);
    let leaves = load_surface(ray, features);
    let mut trace =
        Trace::new(load_origin(ray), load_direction(ray), interval, leaves, ray.load(STATE, 1)).after_last(scene);
    trace.triangle = ray.load_u32(HIT, 2);
    if features.exact_order {
        (trace.error, trace.open) = (ray.load(BOUNDS, 0), ray.load(BOUNDS, 1));
    }
    let before = (trace.triangle, trace.t);
    let mut place = Place { tag, cell: ray.load_u32(STATE, 2), item: ray.load_u32(STATE, 3), trace };

    let structure = features.structure();
    match structure {
        StructureKind::None => all::walk(&mut place, scene),
        StructureKind::Grid => grid::walk(&mut place, ray, scene),
        StructureKind::Irregular => irregular::walk(&mut place, ray, scene),
        StructureKind::Bvh => bvh::walk(&mut place, ray, scene),
    }

    let trace = &place.trace;
    if (trace.triangle, trace.t) != before {
        ray.store(HIT, 0, trace.u);
        ray.store(HIT, 1, trace.v);
        ray.store_u32(HIT, 2, trace.triangle);
        ray.store(STATE, 1, trace.t);
    }
    let mut tag = place.tag;
    if features.exact_order {
        ray.store(BOUNDS, 0, trace.error);
        ray.store(BOUNDS, 1, trace.open);
        if (tag == SHADE || tag == BACKGROUND) && trace.is_open() {
            tag = EXACT;
        }
    }
    ray.store_u32(STATE, 0, tag);
    if structure != StructureKind::None {
        ray.store_u32(STATE, 2, place.cell);
    }
    if features.resumes || structure == StructureKind::None {
        ray.store_u32(STATE, 3, place.item);
    }
    if features.counters {
        ray.store_u32(COUNTERS, 0, ray.load_u32(COUNTERS, 0) + trace.cells);
        ray.store_u32(COUNTERS, 1, ray.load_u32(COUNTERS, 1) + trace.tests);
    }
}
