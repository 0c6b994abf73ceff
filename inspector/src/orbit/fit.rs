//! Frames points as large as they fit, seen from the side of a ray.

use glam::DVec3;

use super::{Lens, Orbit, Pose, size};
use crate::walk::Aabb;

/// The eye is raised by this angle, so that boxes along an axis show more than one face.
const RAISED: f64 = 0.32;
/// Half of the angle of view across the longer side of the picture.
const HALF_ANGLE: f64 = 0.33;

impl Pose {
    /// Turns so that `along` runs from left to right, perpendicular to the view, with up staying up.
    pub(super) fn turn_to_side_of(&mut self, along: DVec3) {
        let Some(along) = along.try_normalize() else { return };
        // A vertical ray has no side of its own.
        let level = DVec3::new(along.x, 0.0, along.z).try_normalize().filter(|_| along.x.hypot(along.z) > 1e-6);
        let right = level.unwrap_or(DVec3::X);
        let side = DVec3::Y.cross(right);
        // Perpendicular to the ray as well as to `side`.
        let up = (DVec3::Y - along * along.y).try_normalize().filter(|_| level.is_some()).unwrap_or(right);
        let (sin, cos) = RAISED.sin_cos();
        let forward = side * cos - up * sin;
        self.pitch = forward.y.clamp(-1.0, 1.0).asin();
        self.yaw = (-forward.x).atan2(-forward.z);
        self.roll = 0.0;
    }
}

impl Orbit {
    /// Frames points, seen from the side of a ray with this direction. `margin` is the share of the picture that stays
    /// free at each edge.
    pub fn frame_from_side(&mut self, points: &[DVec3], along: DVec3, aspect: f64, margin: f64) {
        let Some(&first) = points.first() else { return };
        let aspect = if aspect > 0.0 && aspect.is_finite() { aspect } else { 1.0 };
        self.pose.turn_to_side_of(along);
        let tangent = HALF_ANGLE.tan() / aspect.max(1.0);
        self.pose.lens = Lens::Perspective { vertical_fov: 2.0 * tangent.atan() };
        let (low, high) = points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
        self.radius = size(&Aabb { min: low, max: high });
        let axes = self.pose.axes();
        let free = (1.0 - 2.0 * margin.clamp(0.0, 0.4)).max(0.2);
        let center = (low + high) * 0.5;
        let fits = [tangent * aspect, tangent].map(|tangent| tangent * free);
        // For each axis of the picture, how near the eye may come, and where it then is: every point gives two planes
        // through the eye that it has to be behind.
        let planes = [0, 1].map(|axis: usize| {
            let tangent = fits[axis];
            points.iter().fold([f64::INFINITY; 2], |[more, less], &p| {
                let p = p - center;
                let (across, depth) = (p.dot(axes[axis]), p.dot(axes[2]));
                [more.min(tangent * depth - across), less.min(tangent * depth + across)]
            })
        });
        let nearest = [0, 1].map(|axis| (planes[axis][0] + planes[axis][1]) / (2.0 * fits[axis]));
        let depth = nearest[0].min(nearest[1]).min(-self.radius * 1e-3);
        let across = planes.map(|[more, less]| (less - more) * 0.5);
        if !(depth.is_finite() && across.iter().all(|a| a.is_finite())) {
            return;
        }
        let eye = center + axes[0] * across[0] + axes[1] * across[1] + axes[2] * depth;
        self.pose.distance = -depth;
        self.pose.target = eye + axes[2] * self.pose.distance;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn a_ray_of_any_direction_runs_across_the_view_to_the_right_with_up_staying_up() {
        let mut directions = vec![DVec3::X, DVec3::NEG_Z, DVec3::Y, DVec3::NEG_Y, DVec3::new(1e-9, 1.0, 0.0)];
        directions.extend((0..200).map(|i| {
            let angle = f64::from(i) * 2.399;
            let y = f64::from(i) / 100.0 - 0.995;
            DVec3::new(angle.cos(), 0.0, angle.sin()) * (1.0 - y * y).max(0.0).sqrt() + DVec3::Y * y
        }));
        let size = DVec2::new(480.0, 160.0);
        for along in directions {
            let points = [-along, along, along + DVec3::splat(0.1), along - DVec3::splat(0.1)];
            let mut orbit = Orbit::framing(&Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE }, 3.0);
            orbit.frame_from_side(&points, along, 3.0, 0.05);
            let [right, up, forward] = orbit.pose.axes();
            assert!(forward.dot(along).abs() < 1e-9, "{along}: {forward}");
            assert!(up.y >= 0.0 && right.dot(along) > -1e-9, "{along}: {up} {right}");
            let pixels = points.map(|p| orbit.pixel(p, size).expect("in front of the eye").0);
            assert!(pixels.iter().all(|p| p.cmpge(DVec2::ZERO).all() && p.cmple(size).all()), "{along}: {pixels:?}");
            // It is not small: one side of the picture is used, but for the margins.
            let extent =
                pixels.iter().fold(pixels[0], |a, b| a.max(*b)) - pixels.iter().fold(pixels[0], |a, b| a.min(*b));
            assert!((extent / size).max_element() > 0.85, "{along}: {extent}");
            // The same ray is always seen from the same side.
            let mut again = orbit;
            again.orbit(DVec2::new(90.0, 20.0), size);
            again.frame_from_side(&points, along, 3.0, 0.05);
            assert_eq!(again.pose, orbit.pose);
        }
    }

    #[test]
    fn nonsense_leaves_a_camera() {
        let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE };
        for (points, along, aspect) in [
            (vec![], DVec3::X, 1.0),
            (vec![DVec3::ONE], DVec3::X, 1.0),
            (vec![DVec3::NAN], DVec3::X, 1.0),
            (vec![DVec3::ONE, DVec3::ZERO], DVec3::ZERO, f64::NAN),
        ] {
            let mut orbit = Orbit::framing(&bounds, 1.0);
            orbit.frame_from_side(&points, along, aspect, 0.05);
            assert!(orbit.pose.distance > 0.0 && orbit.pose.target.is_finite(), "{points:?}");
        }
    }
}
