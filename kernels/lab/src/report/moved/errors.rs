//! Errors of t with their predictions, ray by ray.

use std::ops::Range;

use glam::DVec3;
use raystep_kernels::{Ray, Renderer};
use raystep_scenes::Scene;

use super::{Here, Transform};
use crate::report::judge::{Judge, Judged, Right};
use crate::statistics::quantile;
use crate::tidy::Row;

/// Errors of some rays, in extents.
#[derive(Debug, Default)]
pub(super) struct Errors {
    /// Of the arithmetic: error and bound.
    arithmetic: Vec<[f64; 2]>,
    /// One rounding of the largest depth.
    depth_roundings: Vec<f64>,
    /// Of arithmetic and rounding of the scene, for the same rays; empty if they have no original.
    forward: Vec<[f64; 2]>,
}

/// Measures the errors of rays that hit the right triangle. With the original scene, only those are measured that hit
/// the same triangle there: arithmetic and forward error are of the same rays.
pub(super) fn measure(
    judged: &Judged,
    judge: &Judge,
    of: &Range<usize>,
    original: Option<(&Here, Transform)>,
    scene: &Scene,
    rays: &[Ray],
    renderer: &Renderer,
) -> Errors {
    let extent = super::extent(scene) / renderer.data().units.scene_units_per_stream_unit();
    let mut errors = Errors::default();
    for right in judged.right.iter().filter(|right| of.contains(&judge.sample()[right.place])) {
        let index = judge.sample()[right.place];
        if let Some((here, transform)) = original {
            let Some(forward) = forward(right, here, transform, scene, index, &rays[index], renderer.t_scale(index))
            else {
                continue;
            };
            errors.forward.push(forward);
        }
        let length = DVec3::from(judge.direction(right.place)).length() / extent;
        errors.arithmetic.push([(right.t - right.exact.t).abs(), right.exact.t_bound].map(|t| t * length));
        errors.depth_roundings.push(0.5 * f64::from(f32::EPSILON) * right.exact.far * length);
    }
    errors
}

/// How far t changed, and its bound: by rounding of the scene and arithmetic together. `None` if the ray hit another
/// triangle before the scene was rounded.
fn forward(
    right: &Right,
    here: &Here,
    transform: Transform,
    scene: &Scene,
    index: usize,
    ray: &Ray,
    t_scale: f64,
) -> Option<[f64; 2]> {
    let (triangle, t) = here.exact.get(index).copied().flatten()?;
    if triangle != right.exact.triangle {
        return None;
    }
    let corners = &scene.triangles[triangle as usize];
    let [direction, a, b, c] =
        [ray.direction, corners[0], corners[1], corners[2]].map(|v| glam::Vec3::from(v).as_dvec3());
    let normal = (b - a).cross(c - a).try_normalize()?;
    let half_steps =
        |axis: usize| half_step(ray.origin[axis]) + corners.iter().map(|c| half_step(c[axis])).fold(0.0, f64::max);
    let moved: f64 =
        (0..3).map(|axis| normal[axis].abs() * half_steps(axis)).sum::<f64>() / direction.dot(normal).abs();
    let length = direction.length() / (here.extent * transform.scale());
    let error = (right.t * t_scale - t * transform.scale()).abs();
    Some([error, moved + right.exact.t_bound * t_scale].map(|t| t * length))
}

impl Errors {
    pub(super) fn fill(&self, row: Row) -> Row {
        let row = row.set("measured_rays", self.arithmetic.len());
        let row = fill("arithmetic", &self.arithmetic, row);
        let step = quantile(&self.depth_roundings, 1.0);
        let largest = row.number("arithmetic_error_extents_largest");
        let row = row
            .set("depth_rounding_extents_largest", step)
            .set("arithmetic_by_depth_rounding", largest.zip(step).map(|(error, step)| error / step));
        if self.forward.is_empty() {
            return row;
        }
        let beyond = self.forward.iter().filter(|[error, bound]| error > bound).count();
        fill("forward", &self.forward, row).set("beyond_forward_bound_rays", beyond)
    }
}

fn fill(of: &str, errors: &[[f64; 2]], row: Row) -> Row {
    let [error, bound] = [0, 1].map(|i| errors.iter().map(|pair| pair[i]).collect::<Vec<f64>>());
    let own = errors.iter().map(|[error, bound]| error / bound).reduce(f64::max);
    row.set(&format!("{of}_error_extents_largest"), quantile(&error, 1.0))
        .set(&format!("{of}_error_extents_median"), quantile(&error, 0.5))
        .set(&format!("{of}_bound_extents_largest"), quantile(&bound, 1.0))
        .set(&format!("{of}_bound_extents_median"), quantile(&bound, 0.5))
        .set(&format!("{of}_error_by_bound_largest"), own)
}

/// Half the distance to the next f32: the largest error of rounding to this number.
fn half_step(value: f32) -> f64 {
    let magnitude = value.abs();
    0.5 * (f64::from(f32::from_bits(magnitude.to_bits() + 1)) - f64::from(magnitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_step_is_what_rounding_costs_at_most() {
        assert_eq!(half_step(1.0), 0.5f64.powi(24));
        assert_eq!(half_step(-3.0), 0.5f64.powi(23));
        assert_eq!(half_step(0.0), f64::from(f32::from_bits(1)) * 0.5);
    }
}
