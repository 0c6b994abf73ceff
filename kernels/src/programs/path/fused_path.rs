//! Twin of `fused_path.wgsl`: follows a path from its first ray to its end.

use super::connected::{connected, emitted};
use super::scattered::{BY_DEPTH, BY_ESCAPE, scattered};
use super::vertex::Vertex;
use crate::numbers::real::{Real, Vec3};
use crate::programs::closest_hit::fused::traced;
use crate::programs::closest_hit::ray::{load_direction, load_origin};
use crate::programs::closest_hit::states::{DONE, TRAV_SETUP};
use crate::programs::closest_hit::streams::{COLOR, COUNTERS, ENDED, HIT, STATE};
use crate::programs::closest_hit::tracing::Trace;
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::vector::unit3;
use crate::tables::texels::Texels;

/// A ray that leaves a triangle.
fn from<R: Real>([origin, direction]: [Vec3<R>; 2], leaves: u32, t: R) -> Trace<R> {
    Trace::new(origin, direction, [R::zero(), R::from_f32(INF)], leaves, t)
}

/// Processes one ray.
pub fn fused_path<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(STATE, 0) != TRAV_SETUP {
        return;
    }
    let features = &scene.features;
    let infinity = R::from_f32(INF);
    let mut trace = from([load_origin(ray), load_direction(ray)], NO_TRIANGLE, infinity);
    let (mut carried, mut sum) = (Vec3::splat(R::one()), Vec3::splat(R::zero()));
    let (mut depth, mut pdf, mut spent) = (0, R::zero(), [0; 2]);
    let ended = loop {
        traced(&mut trace, ray, scene);
        spent = [spent[0] + trace.cells, spent[1] + trace.tests];
        if depth == 0 {
            ray.store(HIT, 0, trace.u);
            ray.store(HIT, 1, trace.v);
            ray.store_u32(HIT, 2, trace.triangle);
            ray.store(STATE, 1, trace.t);
        }
        let leaves = trace.triangle;
        if leaves == NO_TRIANGLE {
            sum = sum + carried * Vec3::from_f32(scene.shading.background);
            break BY_ESCAPE;
        }
        let hit = (leaves, [trace.u, trace.v]);
        let at = Vertex::new(ray, scene, depth, hit, unit3(trace.direction), carried);
        if features.emissive {
            sum = sum + emitted(&at, scene, trace.origin, pdf);
        }
        if depth == features.depth {
            break BY_DEPTH;
        }
        let next = scattered(&at, scene);
        if let Some(to) = connected(&at, scene) {
            let mut shadow = from([to.origin, to.direction], leaves, to.end);
            shadow.is_shadow = true;
            traced(&mut shadow, ray, scene);
            spent = [spent[0] + shadow.cells, spent[1] + shadow.tests];
            if shadow.triangle == NO_TRIANGLE {
                sum = sum + to.arrives;
            }
        }
        if next.ended != 0 {
            break next.ended;
        }
        (carried, pdf, depth) = (next.throughput, next.pdf, depth + 1);
        trace = from([next.origin, next.direction], leaves, infinity);
    };
    ray.store_vec3(COLOR, sum);
    ray.store_u32(ENDED, 0, ended);
    ray.store_u32(STATE, 0, DONE);
    if features.counters {
        for (layer, spent) in spent.into_iter().enumerate() {
            ray.store_u32(COUNTERS, layer, spent);
        }
        ray.store_u32(COUNTERS, 2, 0);
    }
}
