//! Corners, cameras and rays in traced units, and bounds on their size.

use raystep_scenes::{Camera as SceneCamera, Projection, Scene};

use crate::numbers::units::{Units, exp2, floor_log2};
use crate::options::{Options, Ray, RaySource};
use crate::shared::camera::Camera;
use crate::shared::constants::{BOX_PADDING, INF};
use crate::shared::packed_triangles::{PackedTriangle, pack};
use crate::structures::grid::Corners;

/// Growth of a BVH's boxes, in traced units, if all of them are grown alike: 64 roundings of the largest distance along an
/// axis, of which a triangle's test needs 28 and the slab test 24. Its planes are at `q * (2^e / d) + (p - o) / d`: 7
/// roundings of the distance to the node's corner, 6 of the distance from there, and 1 of the sum; the first distance is
/// below `reach`, the second below twice that, since the planes' spacing is the next power of two.
pub(crate) fn bvh_growth(reach: f32) -> f32 {
    BOX_PADDING * reach.max(f32::MIN_POSITIVE * 1e9)
}

/// All triangles, or those listed.
pub(super) fn packed_triangles(vertices: &[f32], items: Option<&Vec<u32>>) -> Vec<PackedTriangle> {
    // The BVH of an empty scene has a leaf that no ray enters.
    let items = items.filter(|_| !vertices.is_empty());
    let mut packed = vec![[0; 12]; items.map_or(vertices.len() / 9, Vec::len)];
    crate::numbers::parallel::for_chunks(&mut packed, 1 << 14, |first, piece| {
        for (i, to) in piece.iter_mut().enumerate() {
            let id = items.map_or((first + i) as u32, |items| items[first + i]);
            *to = pack(vertices, id);
        }
    });
    packed
}

pub(crate) fn traced_vertices(scene: &Scene, units: Units) -> Vec<f32> {
    let mut vertices = scene.triangles.as_flattened().as_flattened().to_vec();
    let scale = units.scale();
    if scale != 1.0 {
        crate::numbers::parallel::for_chunks(&mut vertices, 1 << 16, |_, piece| {
            for v in piece {
                *v = (f64::from(*v) * scale) as f32;
            }
        });
    }
    vertices
}

/// The camera in the kernels' format. The view plane is at distance 1, whatever the units.
#[must_use]
pub fn traced_camera(camera: &SceneCamera, units: Units, width: u32, height: u32) -> Camera {
    let aspect = f64::from(width) / f64::from(height);
    let (half_height, forward) = match camera.projection {
        Projection::Perspective { vertical_fov } => ((vertical_fov * 0.5).tan(), camera.forward),
        Projection::Orthographic { half_height } => (half_height * units.scale(), camera.forward),
    };
    let to_f32 = |v: glam::DVec3| v.as_vec3().to_array();
    Camera {
        eye: camera.eye.to_array().map(|v| units.to_traced_f64(v)),
        pixel_x: (2.0 / f64::from(width)) as f32,
        right: to_f32(camera.right * (half_height * aspect)),
        pixel_y: (2.0 / f64::from(height)) as f32,
        up: to_f32(camera.up * half_height),
        forward: to_f32(forward),
        ..Camera::default()
    }
}

/// A ray in traced units: the origin scaled, and the direction scaled by its own power of two so that its largest
/// component is in [1, 2), and the ends of its interval with it, at most [`INF`]. Also returns the exponent k of the scene's
/// t: `t_scene = t_traced * 2^k`.
///
/// The interval counts for t as f32 reports it: nothing is reported beyond a t_min of `f32::MAX`, nor at a t_max
/// below the normal numbers, to which smaller t may be rounded up.
#[must_use]
pub fn traced_ray(ray: &Ray, units: Units) -> (Ray, i32) {
    let origin = ray.origin.map(|v| units.to_traced(v));
    let largest = ray.direction.iter().fold(0.0f32, |m, d| m.max(d.abs()));
    let exponent = if largest > 0.0 && largest.is_finite() { -floor_log2(f64::from(largest)) } else { 0 };
    let direction = ray.direction.map(|v| (f64::from(v) * exp2(exponent)) as f32);
    let unit = floor_log2(units.scene_units_per_stream_unit());
    let k = unit + exponent;
    let traced = |t: f32| (f64::from(t) * exp2(-k)).min(f64::from(INF)) as f32;
    let t_min = if ray.t_min < f32::MAX { traced(ray.t_min) } else { INF };
    let t_max = if ray.t_max.is_subnormal() { traced(ray.t_max.next_down()).next_up() } else { traced(ray.t_max) };
    (Ray { origin, direction, t_min, t_max }, k)
}

/// The t of a hit as f32, positive and finite: the nearest that is not smaller, or the largest there is. Only a t below
/// the normal numbers or beyond all of them differs from `t`, which is a traced t times a power of two. So the next hit
/// of a ray has another t, and a ray that starts at the t of a hit does not find it again.
pub(crate) fn as_f32(t: f64) -> f32 {
    let nearest = t as f32;
    if f64::from(nearest) < t { nearest.next_up().min(f32::MAX) } else { nearest.min(f32::MAX) }
}

/// The box of all ray origins, in traced units; `None` if there are none.
pub(crate) fn origins(options: &Options, units: Units) -> Option<Corners> {
    match &options.rays {
        RaySource::Camera { camera, width, height } => {
            let c = traced_camera(camera, units, *width, *height);
            let spread = |axis: usize| match camera.projection {
                Projection::Perspective { .. } => 0.0,
                Projection::Orthographic { .. } => c.right[axis].abs() + c.up[axis].abs(),
            };
            Some([-1.0, 1.0].map(|side| [0, 1, 2].map(|axis| c.eye[axis] + side * spread(axis))))
        }
        RaySource::Given(rays) => {
            let both = |[low, high]: Corners, p: [f32; 3]| {
                [[0, 1, 2].map(|a| low[a].min(p[a])), [0, 1, 2].map(|a| high[a].max(p[a]))]
            };
            let origins = rays.iter().map(|ray| traced_ray(ray, units).0.origin);
            origins.fold(None, |all, p| Some(both(all.unwrap_or([p, p]), p)))
        }
    }
}
