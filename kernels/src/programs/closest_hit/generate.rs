//! Twin of `generate.wgsl`: generates a ray for every pixel.

use crate::numbers::real::Real;
use crate::programs::closest_hit::states::{TRAV_SETUP, UNWRITTEN};
use crate::programs::closest_hit::streams::{ACCUMULATED, ACCUMULATED_SAMPLES, HIT, RAY_DIRECTION, RAY_ORIGIN, STATE};
use crate::scene_data::SceneData;
use crate::shared::camera::{eye_ray, eye_ray_at};
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::samples::jitter;
use crate::tables::texels::Texels;

/// Processes one ray.
pub fn generate<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(STATE, 0) != UNWRITTEN {
        return;
    }
    let (camera, is_perspective) = (&scene.camera, scene.features.perspective);
    let (origin, direction) = if scene.features.samples {
        // The next sample's index grows by the number of samples so far.
        let sample = scene.sampling.first + ray.load(ACCUMULATED, ACCUMULATED_SAMPLES).to_i32() as u32;
        let place = jitter(scene.features.sampler(), [ray.x, ray.y], sample, scene.sampling.seed).map(R::from_f32);
        let place = [R::from_i32(ray.x as i32) + place[0], R::from_i32(ray.y as i32) + place[1]];
        eye_ray_at(camera, is_perspective, place)
    } else {
        eye_ray(camera, is_perspective, ray.x, ray.y)
    };

    ray.store_vec3(RAY_ORIGIN, origin);
    ray.store_vec3(RAY_DIRECTION, direction);
    ray.store(HIT, 0, R::zero());
    ray.store(HIT, 1, R::zero());
    ray.store_u32(HIT, 2, NO_TRIANGLE);
    ray.store_u32(STATE, 0, TRAV_SETUP);
    ray.store(STATE, 1, R::from_f32(INF));
    ray.store_u32(STATE, 2, 0);
    ray.store_u32(STATE, 3, 0);
}
