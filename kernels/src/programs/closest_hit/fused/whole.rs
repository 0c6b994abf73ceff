//! Twin of `whole.wgsl`: a ray from its start to its nearest hit, and from there into the streams.

use super::waiting::Wait;
use super::{taking, taking_open, walk};
use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::programs::closest_hit::ray::{load_direction, load_interval, load_origin, load_surface};
use crate::programs::closest_hit::states::EXACT;
use crate::programs::closest_hit::streams::{COUNTERS, HIT, STATE};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::camera::eye_ray;
use crate::shared::constants::INF;
use crate::tables::texels::Texels;

/// The ray's hit and counters at the end of the dispatch before.
fn resume<R: Real>(trace: &mut Trace<R>, wait: &mut Wait, ray: &Texels<'_, R>, features: &Features) {
    trace.t = ray.load(STATE, 1);
    trace.u = ray.load(HIT, 0);
    trace.v = ray.load(HIT, 1);
    trace.triangle = ray.load_u32(HIT, 2);
    wait.cell = ray.load_u32(STATE, 2);
    wait.item = ray.load_u32(STATE, 3);
    match features.decides {
        true => taking_open::load_bounds(trace, ray),
        false => taking::load_bounds(trace, ray, features),
    }
}

/// A ray from its start to its nearest hit, and from there into the streams.
pub(in crate::programs::closest_hit) fn trace_ray<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    let features = &scene.features;
    let mut wait = Wait::default();
    let has_work = match features.decides {
        true => taking_open::has_work(&mut wait, ray, features),
        // Nobody else has written the state of a ray that is generated here.
        false => features.eye_rays && !features.resumes || taking::has_work(&mut wait, ray, features),
    };
    if !has_work {
        return;
    }
    let (origin, direction) = if features.eye_rays {
        eye_ray(&scene.camera, features.perspective, ray.x, ray.y)
    } else {
        (load_origin(ray), load_direction(ray))
    };
    let has_end = features.any_hit && !features.eye_rays;
    let t = if has_end { ray.load(STATE, 1) } else { R::from_f32(INF) };
    let mut trace =
        Trace::new(origin, direction, load_interval(ray, features), load_surface(ray, features), t).after_last(scene);
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
        next = if features.decides { EXACT } else { taking::waits_as(&trace, features) };
        ray.store_u32(STATE, 2, wait.cell);
        ray.store_u32(STATE, 3, wait.item);
        match features.decides {
            true => taking_open::keep_bounds(&trace, ray),
            false => taking::keep_bounds(&trace, ray, features),
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
