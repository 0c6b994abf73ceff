//! Twin of `generate.wgsl`: makes a ray for every pixel.

use bytemuck::{Pod, Zeroable};

use crate::tables::texels::Texels;
use crate::real::{Real, Vec3};
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::shared::samples::jitter;
use crate::state::{TRAV_SETUP, UNWRITTEN};
use crate::stream::ACCUMULATED_SAMPLES;
use crate::stream::Stream::{Accumulated, Hit, RayDirection, RayOrigin, State};

/// The uniform `camera`, in traced units.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// The eye; the centre of the picture for parallel rays.
    pub eye: [f32; 3],
    /// 2 / width of the picture in pixels.
    pub pixel_x: f32,
    /// From the centre of the view plane to its right edge.
    pub right: [f32; 3],
    /// 2 / height of the picture in pixels.
    pub pixel_y: f32,
    /// To its upper edge.
    pub up: [f32; 3],
    pub(crate) _pad0: u32,
    /// From the eye to the centre of the view plane; along all parallel rays.
    pub forward: [f32; 3],
    pub(crate) _pad1: u32,
}

/// Origin and direction of the ray through a pixel's centre.
pub fn eye_ray<R: Real>(scene: &SceneData, x: u32, y: u32) -> (Vec3<R>, Vec3<R>) {
    let half = R::from_f32(0.5);
    eye_ray_at(scene, [R::from_i32(x as i32) + half, R::from_i32(y as i32) + half])
}

/// Origin and direction of the ray through a place in pixels from the picture's upper left corner.
pub fn eye_ray_at<R: Real>(scene: &SceneData, place: [R; 2]) -> (Vec3<R>, Vec3<R>) {
    let camera = &scene.camera;
    let x = place[0] * R::from_f32(camera.pixel_x) - R::one();
    let y = R::one() - place[1] * R::from_f32(camera.pixel_y);
    let across = Vec3::from_f32(camera.right) * x;
    let upward = Vec3::from_f32(camera.up) * y;
    if scene.features.perspective {
        (Vec3::from_f32(camera.eye), Vec3::from_f32(camera.forward) + across + upward)
    } else {
        (Vec3::from_f32(camera.eye) + across + upward, Vec3::from_f32(camera.forward))
    }
}

/// One ray's work.
pub fn generate<R: Real>(ray: &mut Texels<'_, R>, scene: &SceneData) {
    if ray.load_u32(State, 0) != UNWRITTEN {
        return;
    }
    let (origin, direction) = if scene.features.samples {
        // The next sample's number is how many there are.
        let sample = ray.load(Accumulated, ACCUMULATED_SAMPLES).to_i32() as u32;
        let place = jitter(scene.features.sampler(), [ray.x, ray.y], sample, scene.sampling.seed).map(R::from_f32);
        eye_ray_at(scene, [R::from_i32(ray.x as i32) + place[0], R::from_i32(ray.y as i32) + place[1]])
    } else {
        eye_ray(scene, ray.x, ray.y)
    };

    ray.store_vec3(RayOrigin, origin);
    ray.store_vec3(RayDirection, direction);
    ray.store(Hit, 0, R::zero());
    ray.store(Hit, 1, R::zero());
    ray.store_u32(Hit, 2, NO_TRIANGLE);
    ray.store_u32(State, 0, TRAV_SETUP);
    ray.store(State, 1, R::from_f32(INF));
    ray.store_u32(State, 2, 0);
    ray.store_u32(State, 3, 0);
}
