//! Twin of `fused.wgsl`: traces each ray from its start to its nearest hit, in several dispatches if one allows too few
//! loop iterations. The loop is in the module of the structure.

mod all;
mod bvh;
mod bvh_binary;
mod grid;
mod irregular;
mod taking;
mod taking_open;
mod waiting;
mod waiting_in_grid;
mod whole;

use crate::numbers::real::{Real, Vec3};
use crate::options::Ray;
use crate::options::features::{Features, StructureKind};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::texels::Texels;
use waiting::Wait;
pub(super) use whole::trace_ray;

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
pub(super) fn hit_of<R: Real>(ray: &Ray, last: u32, scene: &SceneData) -> Option<(u32, [f32; 3])> {
    let Features { any_hit, intervals, .. } = scene.features;
    let ends = [scene.features.begin(ray), ray.t_max].map(R::from_f32);
    let far = R::from_f32(INF);
    let (t, interval) = (if any_hit { ends[1] } else { far }, if intervals { ends } else { [R::zero(), far] });
    let [origin, direction] = [ray.origin, ray.direction].map(Vec3::from_f32);
    let new = || Trace::new(origin, direction, interval, last, t).after_last(scene);
    let mut trace = new();
    traced(&mut trace, &mut Texels::none(), scene);
    if trace.is_open() {
        trace = new();
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
