//! The densities of a path's samples of light, from its states: by which pdf each was found, and what it weighs.

use super::connected::INVERSE_PI;
use super::emitters::{pdf_by_area, share_of_hit, weight};
use crate::numbers::real::Vec3;
use crate::program::RayState;
use crate::program::paths::Density;
use crate::programs::closest_hit::shade::surface::{material_of, surface_normal};
use crate::scene_data::SceneData;
use crate::shared::emitters::PUNCTUAL;
use crate::shared::start::{on_side, start_of};
use crate::shared::vector::{cross3, dot3, unit3};

/// A pdf that the streams hold, where 0 stands for the only direction.
fn known(pdf: f64) -> Option<f64> {
    (pdf > 0.0).then_some(pdf)
}

/// Of the background, which no shadow ray is cast to.
pub(super) fn of_background(ray: &RayState) -> Density {
    Density { pdf: known(ray.bounce.map_or(0.0, |bounce| f64::from(bounce.pdf))), weight: 1.0 }
}

/// Of a surface that emits, from the ray that hit it.
pub(super) fn of_emitter_hit(data: &SceneData, ray: &RayState) -> Option<Density> {
    let (triangle, by) = ray.triangle.zip(ray.barycentric)?;
    let direction = unit3(Vec3::<f64>::from_f32(ray.direction));
    let start = start_of(data.corners(triangle), by.map(f64::from), direction);
    let way = start.point - Vec3::from_f32(ray.origin);
    let area: f64 = pdf_by_area(data, material_of(data, triangle));
    let of_point = area * dot3(way, way) / dot3(start.normal, direction).abs();
    let of_direction = f64::from(ray.bounce?.pdf);
    Some(Density { pdf: known(of_direction), weight: share_of_hit(&data.features, of_direction, of_point) })
}

/// Of an emitter that was picked, from the ray that hit the surface and the shadow ray that leaves it.
pub(super) fn of_light_sample(data: &SceneData, ray: &RayState, shadow: &RayState) -> Option<Density> {
    let (id, (triangle, by)) = (shadow.light?, ray.triangle.zip(ray.barycentric)?);
    if id & PUNCTUAL != 0 {
        return Some(Density { pdf: None, weight: 1.0 });
    }
    let to = Vec3::<f64>::from_f32(shadow.direction);
    let [a, b, c]: [Vec3<f64>; 3] = data.corners(id);
    let material = material_of(data, id);
    let facing = dot3(unit3(cross3(unit3(b - a), unit3(c - a))), unit3(to)).abs();
    let area: f64 = pdf_by_area(data, material);
    let pdf = area * dot3(to, to) / facing;
    let [u, v] = by.map(f64::from);
    let start = start_of(data.corners(triangle), [u, v], unit3(Vec3::from_f32(ray.direction)));
    let normal = on_side(&start, surface_normal(data, triangle, u, v));
    let of_direction = dot3(normal, unit3(to)) * f64::from(INVERSE_PI);
    Some(Density { pdf: Some(pdf), weight: if data.features.mis { weight(pdf, of_direction) } else { 1.0 } })
}
