//! Perspective and parallel views.

use glam::{DMat4, DVec4};
use raystep_scenes::Projection;
use serde::{Deserialize, Serialize};

/// The projection.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Lens {
    /// From the eye.
    Perspective {
        /// Full vertical angle of view, radians, in (0, pi).
        vertical_fov: f64,
    },
    /// Parallel.
    Orthographic {
        /// Half the picture's height, above 0.
        half_height: f64,
    },
}

impl Lens {
    /// From a scene's camera.
    #[must_use]
    pub fn of(projection: Projection) -> Self {
        match projection {
            Projection::Perspective { vertical_fov } => Self::Perspective { vertical_fov },
            Projection::Orthographic { half_height } => Self::Orthographic { half_height },
        }
    }

    /// For a scene's camera.
    #[must_use]
    pub fn projection(self) -> Projection {
        match self {
            Self::Perspective { vertical_fov } => Projection::Perspective { vertical_fov },
            Self::Orthographic { half_height } => Projection::Orthographic { half_height },
        }
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Orthographic { half_height } => Self::Orthographic { half_height: half_height * factor },
            perspective => perspective,
        }
    }

    /// How far looking around turns over the picture's height.
    pub(super) fn vertical_angle(self) -> f64 {
        match self {
            Self::Perspective { vertical_fov } => vertical_fov,
            Self::Orthographic { .. } => 1.0,
        }
    }

    /// Depth 1 at `near`; 0 at infinity with perspective, and at `far` without.
    pub(super) fn clip_from_view(self, aspect: f64, near: f64, far: f64) -> DMat4 {
        let aspect = if aspect > 0.0 { aspect } else { 1.0 };
        match self {
            Self::Perspective { vertical_fov } => {
                let scale = 1.0 / (vertical_fov * 0.5).tan();
                DMat4::from_cols(DVec4::X * (scale / aspect), DVec4::Y * scale, -DVec4::W, DVec4::Z * near)
            }
            Self::Orthographic { half_height } => {
                // The eye of a parallel view is arbitrary: points behind it are visible as well.
                let (scale, depth) = (1.0 / half_height, 1.0 / (2.0 * far));
                let z = DVec4::Z * depth;
                DMat4::from_cols(DVec4::X * (scale / aspect), DVec4::Y * scale, z, DVec4::new(0.0, 0.0, 0.5, 1.0))
            }
        }
    }
}
