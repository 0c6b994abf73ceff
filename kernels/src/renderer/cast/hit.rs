//! What a ray that is cast hits.

use bytemuck::{Pod, Zeroable};
use raystep_scenes::Scene;

use crate::numbers::units::exp2;
use crate::options::Ray;
use crate::scene_data::{SceneData, as_f32, traced_ray};
use crate::shared::constants::NO_TRIANGLE;
use crate::shared::exact::values::rounded_values;

/// The result of one ray.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CastHit {
    /// t of the hit, in multiples of the ray's direction: positive and finite; infinite without a hit.
    ///
    /// For a direction so short that t exceeds f32's range, it is `f32::MAX`, and no hit is beyond a t_min of `f32::MAX`.
    /// For one so long that t is below f32's normal numbers, it is rounded up to the next number, and counts as that
    /// between t_min and t_max.
    pub t: f32,
    /// Barycentric weight of the triangle's vertex 1.
    pub u: f32,
    /// Barycentric weight of the triangle's vertex 2.
    pub v: f32,
    /// The triangle's index in the scene; `u32::MAX` without a hit.
    pub triangle: u32,
    /// The index of its material in the scene; `u32::MAX` without a hit.
    pub material: u32,
}

impl CastHit {
    /// The result of a ray that hits nothing.
    pub const MISS: Self = Self { t: f32::INFINITY, u: 0.0, v: 0.0, triangle: NO_TRIANGLE, material: u32::MAX };

    /// Whether the ray hit something.
    #[must_use]
    pub fn is_hit(&self) -> bool {
        self.triangle != NO_TRIANGLE
    }
    /// That of a hit in traced units.
    pub(super) fn in_scene(scene: &Scene, triangle: u32, [t, u, v]: [f32; 3], t_scale: f64) -> Self {
        let material = scene.triangle_materials.get(triangle as usize).copied().unwrap_or(u32::MAX);
        // By an exact order, a hit counts whose t rounds to less.
        let t = f64::from(t).max(0.0) + 0.0;
        Self { t: as_f32(t * t_scale), u, v, triangle, material }
    }

    /// Replaces t, u and v by the exact values, rounded once: on the CPU, to which results come anyway.
    pub(super) fn round(&mut self, ray: &Ray, data: &SceneData) {
        if !self.is_hit() {
            return;
        }
        let (traced, exponent) = traced_ray(ray, data.units);
        let corners = data.corners::<f32>(self.triangle).map(|corner| corner.to_array());
        if let Some([t, u, v]) = rounded_values(traced.origin, traced.direction, corners) {
            (self.t, self.u, self.v) = (as_f32(f64::from(t) * exp2(exponent)), u, v);
        }
    }
}
