//! An interactive camera: it orbits about a point, pans, zooms towards the cursor, flies, and frames a box.
//!
//! It stores angles instead of axes: the axes derived from them stay orthonormal during any drag, looking straight up
//! or down is an ordinary view, and the camera never tips over. Up is +Y, as in the scene. Lengths are in the caller's
//! units; [`Orbit::scaled`] converts between units.

mod fit;
mod lens;
mod saved;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat4, DVec2, DVec3};
use raystep_scenes::Camera;
use serde::{Deserialize, Serialize};

use crate::walk::Aabb;
pub use lens::Lens;

/// Position and orientation of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The centre of the orbit.
    pub target: DVec3,
    /// From the eye to the target; above 0.
    pub distance: f64,
    /// Turn about +Y, radians: 0 looks along -Z, growing to the left.
    pub yaw: f64,
    /// Turn upward, radians, from -pi/2 to pi/2.
    pub pitch: f64,
    /// Turn about the view, radians, clockwise as the camera tilts to the right. No drag changes it.
    pub roll: f64,
    /// The projection.
    pub lens: Lens,
}

/// An interactive camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "saved::Saved", into = "saved::Saved")]
pub struct Orbit {
    /// Its state.
    pub pose: Pose,
    home: Pose,
    /// Half the size of the object it looks at: determines speed and limits.
    radius: f64,
}

/// Distance at which a box is framed, relative to that at which it touches the edge of the picture.
const ROOM: f64 = 1.05;

/// Limits of the distance from eye to target, relative to the size of the object.
const NEAREST: f64 = 1e-6;
const FARTHEST: f64 = 1e4;

impl Pose {
    /// Unit vectors to the right, up and into the picture.
    #[must_use]
    pub fn axes(&self) -> [DVec3; 3] {
        let ((sin_yaw, cos_yaw), (sin_pitch, cos_pitch)) = (self.yaw.sin_cos(), self.pitch.sin_cos());
        let forward = DVec3::new(-sin_yaw * cos_pitch, sin_pitch, -cos_yaw * cos_pitch);
        let right = DVec3::new(cos_yaw, 0.0, -sin_yaw);
        let up = right.cross(forward);
        let (sin, cos) = self.roll.sin_cos();
        [right * cos - up * sin, up * cos + right * sin, forward]
    }

    /// The eye.
    #[must_use]
    pub fn eye(&self) -> DVec3 {
        self.target - self.axes()[2] * self.distance
    }
}

impl Orbit {
    /// From one of a scene's cameras, orbiting about the point in front of it that is nearest to the middle of
    /// `bounds`. Preserves lens, roll and eye up to rounding.
    #[must_use]
    pub fn from_camera(camera: &Camera, bounds: &Aabb) -> Self {
        let forward = camera.forward;
        let level = forward.x.hypot(forward.z);
        let pitch = forward.y.atan2(level);
        // Straight up or down, the right of the picture defines the orientation.
        let yaw = if level > 1e-9 { (-forward.x).atan2(-forward.z) } else { (-camera.right.z).atan2(camera.right.x) };
        let radius = size(bounds);
        let ahead = (bounds.center() - camera.eye).dot(forward);
        let distance = if ahead > radius * 1e-3 { ahead } else { radius };
        let target = camera.eye + forward * distance;
        let mut pose = Pose { target, distance, yaw, pitch, roll: 0.0, lens: Lens::of(camera.projection) };
        let [right, up, _] = pose.axes();
        pose.roll = (-camera.right.dot(up)).atan2(camera.right.dot(right));
        Self { pose, home: pose, radius }
    }

    /// The equivalent scene camera.
    #[must_use]
    pub fn to_camera(&self, name: &str) -> Camera {
        let [right, up, forward] = self.pose.axes();
        Camera { name: name.into(), eye: self.pose.eye(), right, up, forward, projection: self.pose.lens.projection() }
    }

    /// A view of a box from the front, a little above and to the right.
    #[must_use]
    pub fn framing(bounds: &Aabb, aspect: f64) -> Self {
        let lens = Lens::Perspective { vertical_fov: 40f64.to_radians() };
        let target = bounds.center();
        let pose = Pose { target, distance: 1.0, yaw: 0.6, pitch: -0.4, roll: 0.0, lens };
        let mut orbit = Self { pose, home: pose, radius: size(bounds) };
        orbit.frame(bounds, aspect);
        orbit.home = orbit.pose;
        orbit
    }

    /// The same view in other units, of which `factor` make one of these.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let pose = |p: Pose| Pose {
            target: p.target * factor,
            distance: p.distance * factor,
            lens: p.lens.scaled(factor),
            ..p
        };
        Self { pose: pose(self.pose), home: pose(self.home), radius: self.radius * factor }
    }

    /// Resets the camera.
    pub fn reset(&mut self) {
        self.pose = self.home;
    }

    /// Orbits about the target: a drag over the picture's height is half a turn.
    pub fn orbit(&mut self, drag_px: DVec2, size_px: DVec2) {
        let angle = drag_px * (PI / size_px.y.max(1.0));
        self.turn(angle);
    }

    /// Looks around from the eye.
    pub fn look(&mut self, drag_px: DVec2, size_px: DVec2) {
        let eye = self.pose.eye();
        let angle = drag_px * (self.pose.lens.vertical_angle() / size_px.y.max(1.0));
        self.turn(angle);
        self.pose.target = eye + self.pose.axes()[2] * self.pose.distance;
    }

    fn turn(&mut self, angle: DVec2) {
        if !angle.is_finite() {
            return;
        }
        self.pose.yaw = (self.pose.yaw - angle.x).rem_euclid(2.0 * PI);
        self.pose.pitch = (self.pose.pitch - angle.y).clamp(-FRAC_PI_2, FRAC_PI_2);
    }

    /// Pans, so that points at the distance of the target stay under the cursor.
    pub fn pan(&mut self, drag_px: DVec2, size_px: DVec2) {
        let [right, up, _] = self.pose.axes();
        let drag = drag_px * (2.0 * self.half_height() / size_px.y.max(1.0));
        if drag.is_finite() {
            self.pose.target += up * drag.y - right * drag.x;
        }
    }

    /// Approaches (`factor` below 1) or retreats, with `anchor` fixed in the picture: the point under the cursor, if it
    /// is known, otherwise see [`under`](Self::under).
    pub fn zoom(&mut self, factor: f64, anchor: DVec3) {
        let [_, _, forward] = self.pose.axes();
        let wanted = self.pose.distance * factor;
        if !(wanted > 0.0 && wanted.is_finite() && anchor.is_finite()) {
            return;
        }
        let distance = wanted.clamp(self.radius * NEAREST, self.radius * FARTHEST);
        let factor = distance / self.pose.distance;
        let eye = anchor + (self.pose.eye() - anchor) * factor;
        self.pose.distance = distance;
        self.pose.target = eye + forward * distance;
        self.pose.lens = match self.pose.lens {
            Lens::Orthographic { half_height } => Lens::Orthographic { half_height: half_height * factor },
            perspective => perspective,
        };
    }

    /// The point under a pixel at the distance of the target.
    #[must_use]
    pub fn under(&self, pixel: DVec2, size_px: DVec2) -> DVec3 {
        let [right, up, _] = self.pose.axes();
        let at = self.of_middle(pixel, size_px) * self.half_height();
        self.pose.target + right * at.x + up * at.y
    }

    /// Flies: `steps` to the right, up and forward, in units of the distance to the target or the size of the object,
    /// whichever is smaller.
    pub fn fly(&mut self, steps: DVec3) {
        let [right, up, forward] = self.pose.axes();
        let speed = self.pose.distance.min(self.radius);
        let by = (right * steps.x + up * steps.y + forward * steps.z) * speed;
        if by.is_finite() {
            self.pose.target += by;
        }
    }

    /// Frames a box from the current direction, as close as the whole box fits.
    pub fn frame(&mut self, bounds: &Aabb, aspect: f64) {
        let radius = size(bounds);
        self.radius = radius;
        self.pose.target = bounds.center();
        let narrow = if aspect > 0.0 { aspect.min(1.0) } else { 1.0 };
        match &mut self.pose.lens {
            Lens::Perspective { vertical_fov } => {
                let half = ((*vertical_fov * 0.5).tan() * narrow).atan();
                self.pose.distance = radius / half.sin() * ROOM;
            }
            Lens::Orthographic { half_height } => {
                *half_height = radius / narrow * ROOM;
                self.pose.distance = radius * 4.0;
            }
        }
    }

    /// The ray through a pixel: where it starts, and its unit direction. Pixel (0, 0) is the picture's upper left
    /// corner; its first pixel's centre is (0.5, 0.5).
    #[must_use]
    pub fn ray(&self, pixel: DVec2, size_px: DVec2) -> [DVec3; 2] {
        let [right, up, forward] = self.pose.axes();
        let eye = self.pose.eye();
        let at = self.of_middle(pixel, size_px);
        match self.pose.lens {
            Lens::Perspective { vertical_fov } => {
                let at = at * (vertical_fov * 0.5).tan();
                [eye, (forward + right * at.x + up * at.y).normalize()]
            }
            Lens::Orthographic { half_height } => {
                let at = at * half_height;
                [eye + right * at.x + up * at.y, forward]
            }
        }
    }

    /// Where a point is seen, and its depth; `None` behind the eye.
    #[must_use]
    pub fn pixel(&self, point: DVec3, size_px: DVec2) -> Option<(DVec2, f64)> {
        let [right, up, forward] = self.pose.axes();
        let from_eye = point - self.pose.eye();
        let depth = from_eye.dot(forward);
        let half_height = match self.pose.lens {
            Lens::Perspective { vertical_fov } if depth > 0.0 => depth * (vertical_fov * 0.5).tan(),
            Lens::Perspective { .. } => return None,
            Lens::Orthographic { half_height } => half_height,
        };
        let at = DVec2::new(from_eye.dot(right), -from_eye.dot(up)) / half_height;
        let pixel = (at * size_px.y + size_px) * 0.5;
        pixel.is_finite().then_some((pixel, depth))
    }

    /// From lengths relative to `center` to clip space. Depth is 1 near the eye and 0 at infinity, which suits the
    /// resolution of f32; there is no far plane.
    #[must_use]
    pub fn clip_from_world(&self, center: DVec3, aspect: f64) -> DMat4 {
        let [right, up, forward] = self.pose.axes();
        let eye = self.pose.eye() - center;
        let view = DMat4::from_cols(right.extend(0.0), up.extend(0.0), (-forward).extend(0.0), glam::DVec4::W)
            .transpose()
            * DMat4::from_translation(-eye);
        self.pose.lens.clip_from_view(aspect, self.near(), self.pose.distance + self.radius) * view
    }

    /// The near plane.
    #[must_use]
    pub fn near(&self) -> f64 {
        self.pose.distance.min(self.radius) * 1e-3
    }

    /// Pixels from the middle, to the right and up, in halves of the picture's height.
    fn of_middle(&self, pixel: DVec2, size_px: DVec2) -> DVec2 {
        let at = (pixel * 2.0 - size_px) / size_px.y.max(1.0);
        DVec2::new(at.x, -at.y)
    }

    /// Half of the picture's height at the target.
    fn half_height(&self) -> f64 {
        match self.pose.lens {
            Lens::Perspective { vertical_fov } => self.pose.distance * (vertical_fov * 0.5).tan(),
            Lens::Orthographic { half_height } => half_height,
        }
    }
}

/// Half the diagonal; of a single point, a thousandth of its distance from the origin, its only scale.
fn size(bounds: &Aabb) -> f64 {
    let radius = bounds.radius();
    if radius > 0.0 && radius.is_finite() { radius } else { bounds.center().length().max(1.0) * 1e-3 }
}

#[cfg(test)]
mod tests;
