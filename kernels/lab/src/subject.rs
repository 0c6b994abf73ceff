//! The subject of a measurement: a scene with a view.

use std::fmt;

use raystep_kernels::RaySource;
use raystep_scenes::{Camera, Scene};

use crate::Hash;

/// A scene and its view.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The scene.
    pub scene: Scene,
    /// The view.
    pub camera: Camera,
    /// Hash of all files it was read from.
    pub hash: Hash,
    /// Where it was read from, for display.
    pub file: String,
}

impl Subject {
    /// One ray through the centre of each pixel.
    #[must_use]
    pub fn camera_rays(&self, Size { width, height }: Size) -> RaySource {
        RaySource::Camera { camera: self.camera.clone(), width, height }
    }
}

/// An image's size in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}
