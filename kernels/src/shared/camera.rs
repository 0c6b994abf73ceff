//! Twin of `camera.wgsl`: the ray through a point of the image.

use bytemuck::{Pod, Zeroable};

use crate::numbers::real::{Real, Vec3};

/// The uniform `camera`, in traced units.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// The eye; for parallel rays the centre of the image.
    pub eye: [f32; 3],
    /// 2 / width of the image in pixels.
    pub pixel_x: f32,
    /// From the centre of the view plane to its right edge.
    pub right: [f32; 3],
    /// 2 / height of the image in pixels.
    pub pixel_y: f32,
    /// From the centre of the view plane to its upper edge.
    pub up: [f32; 3],
    pub(crate) _pad0: u32,
    /// From the eye to the centre of the view plane; the direction of parallel rays.
    pub forward: [f32; 3],
    pub(crate) _pad1: u32,
}

/// Origin and direction of the ray through a pixel's centre; rays are parallel unless they fan out from the eye.
pub fn eye_ray<R: Real>(camera: &Camera, is_perspective: bool, x: u32, y: u32) -> (Vec3<R>, Vec3<R>) {
    let half = R::from_f32(0.5);
    eye_ray_at(camera, is_perspective, [R::from_i32(x as i32) + half, R::from_i32(y as i32) + half])
}

/// Origin and direction of the ray through a point, in pixels from the image's upper left corner.
pub fn eye_ray_at<R: Real>(camera: &Camera, is_perspective: bool, place: [R; 2]) -> (Vec3<R>, Vec3<R>) {
    let x = place[0] * R::from_f32(camera.pixel_x) - R::one();
    let y = R::one() - place[1] * R::from_f32(camera.pixel_y);
    let across = Vec3::from_f32(camera.right) * x;
    let upward = Vec3::from_f32(camera.up) * y;
    if is_perspective {
        (Vec3::from_f32(camera.eye), Vec3::from_f32(camera.forward) + across + upward)
    } else {
        (Vec3::from_f32(camera.eye) + across + upward, Vec3::from_f32(camera.forward))
    }
}
