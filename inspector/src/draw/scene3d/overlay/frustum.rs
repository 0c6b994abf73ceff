//! The camera that generates the rays.

use glam::DVec3;
use raystep_kernels::scene_data::SceneData;

use crate::walk::{Aabb, to_f64};

/// Position and view of the traced camera, in traced units.
pub(in super::super) struct Frustum {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    is_perspective: bool,
}

impl Frustum {
    /// `None` for input rays.
    pub(in super::super) fn of(data: &SceneData) -> Option<Self> {
        let camera = &data.camera;
        let [eye, right, up, forward] = [camera.eye, camera.right, camera.up, camera.forward].map(to_f64);
        let is_camera = [right, up, forward].iter().all(|v| v.length_squared() > 0.0);
        is_camera.then_some(Self { eye, right, up, forward, is_perspective: data.features.perspective })
    }

    /// A small pyramid at the eye with a mark at its top, or a box for parallel rays.
    pub(super) fn lines(&self, scene: &Aabb) -> Vec<[DVec3; 2]> {
        let depth = scene.radius() * 0.22;
        let ahead = self.eye + self.forward.normalize_or_zero() * depth;
        // The view plane lies at distance 1, whatever the units.
        let (near, far) = if self.is_perspective { (0.0, depth) } else { (1.0, 1.0) };
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let across = corners.map(|(x, y)| self.right * x + self.up * y);
        let mut lines = Vec::new();
        for i in 0..4 {
            let (this, next) = (across[i], across[(i + 1) % 4]);
            lines.push([ahead + this * far, ahead + next * far]);
            lines.push([self.eye + this * near, ahead + this * far]);
            if !self.is_perspective {
                lines.push([self.eye + this * near, self.eye + next * near]);
            }
        }
        let top = ahead + self.up * (far * 1.35);
        lines.push([ahead + (self.up + self.right * 0.3) * far, top]);
        lines.push([ahead + (self.up - self.right * 0.3) * far, top]);
        lines
    }
}
