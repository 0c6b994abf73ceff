//! A camera as saved: plain numbers, clamped to their ranges when they are read.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{Lens, Orbit, Pose};

#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Saved {
    view: SavedPose,
    home: SavedPose,
    radius: f64,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
struct SavedPose {
    target: [f64; 3],
    distance: f64,
    yaw: f64,
    pitch: f64,
    roll: f64,
    lens: Lens,
}

impl From<Pose> for SavedPose {
    fn from(p: Pose) -> Self {
        let Pose { target, distance, yaw, pitch, roll, lens } = in_range(p);
        Self { target: target.to_array(), distance, yaw, pitch, roll, lens }
    }
}

impl From<SavedPose> for Pose {
    fn from(p: SavedPose) -> Self {
        let SavedPose { target, distance, yaw, pitch, roll, lens } = p;
        in_range(Self { target: DVec3::from_array(target), distance, yaw, pitch, roll, lens })
    }
}

impl From<Orbit> for Saved {
    fn from(orbit: Orbit) -> Self {
        Self { view: orbit.pose.into(), home: orbit.home.into(), radius: positive(orbit.radius) }
    }
}

impl From<Saved> for Orbit {
    fn from(saved: Saved) -> Self {
        Self { pose: saved.view.into(), home: saved.home.into(), radius: positive(saved.radius) }
    }
}

fn in_range(p: Pose) -> Pose {
    let finite = |v: f64, instead: f64| if v.is_finite() { v } else { instead };
    Pose {
        target: DVec3::from_array(p.target.to_array().map(|v| finite(v, 0.0))),
        distance: positive(p.distance),
        yaw: finite(p.yaw, 0.0),
        pitch: finite(p.pitch, 0.0).clamp(-FRAC_PI_2, FRAC_PI_2),
        roll: finite(p.roll, 0.0),
        lens: match p.lens {
            Lens::Perspective { vertical_fov } => {
                Lens::Perspective { vertical_fov: finite(vertical_fov, 0.7).clamp(1e-3, 3.1) }
            }
            Lens::Orthographic { half_height } => Lens::Orthographic { half_height: positive(half_height) },
        },
    }
}

fn positive(v: f64) -> f64 {
    if v > 0.0 && v.is_finite() { v } else { 1.0 }
}
