//! Twin of `fused.wgsl`: traces each ray from its start to its nearest hit, in several dispatches if one allows too few
//! loop iterations. The loop is in the module of the structure.

mod all;
mod bvh;
mod bvh_binary;
mod grid;
mod irregular;
mod waiting;
mod waiting_in_grid;

use crate::numbers::real::{Real, Vec3};
use crate::options::Ray;
use crate::options::features::{Features, StructureKind};
use crate::programs::closest_hit::ray::{load_direction, load_interval, load_origin, load_surface};
use crate::programs::closest_hit::streams::{BOUNDS, COUNTERS, HIT, STATE};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::camera::eye_ray;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::texels::Texels;
use waiting::{WAITS, Wait};

/// The ray's hit and counters at the end of the dispatch before.
fn resume<R: Real>(trace: &mut Trace<R>, wait: &mut Wait, ray: &Texels<'_, R>, features: &Features) {
    trace.t = ray.load(STATE, 1);
    trace.u = ray.load(HIT, 0);
    trace.v = ray.load(HIT, 1);
    trace.triangle = ray.load_u32(HIT, 2);
    wait.cell = ray.load_u32(STATE, 2);
    wait.item = ray.load_u32(STATE, 3);
    if features.exact_order {
        (trace.error, trace.open) = (ray.load(BOUNDS, 0), ray.load(BOUNDS, 1));
    }
}

/// Through the structure, until the walk is over or waits.
fn walk<R: Real>(trace: &mut Trace<R>, wait: &mut Wait, ray: &mut Texels<'_, R>, scene: &SceneData) {
    match scene.features.structure() {
        StructureKind::None => all::trace(trace, wait, scene),
        StructureKind::Grid => grid::trace(trace, wait, ray, scene),
        StructureKind::Irregular => irregular::trace(trace, wait, ray, scene),
        StructureKind::Bvh if !scene.features.wide => bvh_binary::trace(trace, wait, ray, scene),
        StructureKind::Bvh => bvh::trace(trace, wait, ray, scene),
    }
}

/// The same of a ray in registers, in a run whose walks never wait.
pub(in crate::programs) fn traced<R: Real>(trace: &mut Trace<R>, ray: &mut Texels<'_, R>, scene: &SceneData) {
    walk(trace, &mut Wait::default(), ray, scene);
}

/// [`HitOf`](crate::program::results::HitOf): what [`fused`] stores for a ray.
pub(super) fn hit_of<R: Real>(ray: &Ray, scene: &SceneData) -> Option<(u32, [f32; 3])> {
    let Features { any_hit, intervals, .. } = scene.features;
    let ends = [ray.t_min, ray.t_max].map(R::from_f32);
    let far = R::from_f32(INF);
    let (t, interval) = (if any_hit { ends[1] } else { far }, if intervals { ends } else { [R::zero(), far] });
    let [origin, direction] = [ray.origin, ray.direction].map(Vec3::from_f32);
    let mut trace = Trace::new(origin, direction, interval, NO_TRIANGLE, t);
    traced(&mut trace, &mut Texels::none(), scene);
    if trace.is_open() {
        trace = Trace::new(origin, direction, interval, NO_TRIANGLE, t);
        trace.decides = true;
        traced(&mut trace, &mut Texels::none(), scene);
    }
    let [t, u, v] = [trace.t, trace.u, trace.v].map(|value| value.to_f64() as f32);
    (trace.triangle != NO_TRIANGLE && t < INF).then_some((trace.triangle, [t, u, v]))
}

/// Processes one ray.
pub fn fused<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    trace_ray(ray, scene);
}

/// A ray from its start to its nearest hit, and from there into the streams.
pub(super) fn trace_ray<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let features = &scene.features;
    let mut wait = Wait::default();
    if (!features.eye_rays || features.resumes || features.decides) && !wait.has_work(ray, features) {
        return;
    }
    let (origin, direction) = if features.eye_rays {
        eye_ray(&scene.camera, features.perspective, ray.x, ray.y)
    } else {
        (load_origin(ray), load_direction(ray))
    };
    let has_end = features.any_hit && !features.eye_rays;
    let t = if has_end { ray.load(STATE, 1) } else { R::from_f32(INF) };
    let mut trace = Trace::new(origin, direction, load_interval(ray, features), load_surface(ray, features), t);
    trace.decides = features.decides;
    if wait.before {
        resume(&mut trace, &mut wait, ray, features);
    }
    if features.counters && (wait.before || features.decides) {
        trace.cells = ray.load_u32(COUNTERS, 0);
        trace.tests = ray.load_u32(COUNTERS, 1);
    }

    walk(&mut trace, &mut wait, ray, scene);

    ray.store(HIT, 0, trace.u);
    ray.store(HIT, 1, trace.v);
    ray.store_u32(HIT, 2, trace.triangle);
    let mut next = trace.ended_as();
    if wait.after {
        next = wait.waits_as(&trace, features);
        ray.store_u32(STATE, 2, wait.cell);
        ray.store_u32(STATE, 3, wait.item);
        if features.exact_order {
            ray.store(BOUNDS, 0, trace.error);
            ray.store(BOUNDS, 1, if features.decides { R::from_f32(WAITS) } else { trace.open });
        }
    }
    ray.store_u32(STATE, 0, next);
    ray.store(STATE, 1, trace.t);
    if features.counters {
        ray.store_u32(COUNTERS, 0, trace.cells);
        ray.store_u32(COUNTERS, 1, trace.tests);
        if !features.decides {
            ray.store_u32(COUNTERS, 2, 0);
        }
    }
}
