//! Twin of `decide.wgsl`: traces those rays again whose nearest hit the bounds on rounding errors leave open.

use super::fused::trace_ray;
use crate::numbers::real::Real;
use crate::scene_data::SceneData;
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn decide<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    trace_ray(ray, scene);
}
