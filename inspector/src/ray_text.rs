//! A ray as text: six numbers, decimal or bits.

use std::str::FromStr;

use raystep_kernels::Ray;
use raystep_scenes::Scene;
use serde::{Deserialize, Serialize};

/// A ray as a person gives it: origin and direction, in the coordinates of the scene's file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GivenRay(pub [f64; 6]);

impl GivenRay {
    /// The ray in a scene.
    #[must_use]
    pub fn in_scene(self, scene: &Scene) -> Ray {
        let [ox, oy, oz, dx, dy, dz] = self.0;
        Ray::in_file([ox, oy, oz], [dx, dy, dz], scene.offset)
    }
}

/// The text is not a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RayTextError {
    /// Not six numbers.
    #[error("expected six numbers separated by commas, decimal or hex bits such as 0x3f800000")]
    NotSix,
    /// A number is not finite, or the direction has no length.
    #[error("expected finite numbers, and a direction other than 0")]
    NoRay,
}

/// `ox,oy,oz,dx,dy,dz`, each decimal or the bits of an f32 in hex.
impl FromStr for GivenRay {
    type Err = RayTextError;

    fn from_str(text: &str) -> Result<Self, RayTextError> {
        let number = |text: &str| match text.trim().strip_prefix("0x") {
            Some(bits) => u32::from_str_radix(bits, 16).ok().map(|bits| f64::from(f32::from_bits(bits))),
            None => text.trim().parse().ok(),
        };
        let numbers: Option<Vec<f64>> = text.split(',').take(7).map(number).collect();
        let ray: [f64; 6] = numbers.and_then(|n| n.try_into().ok()).ok_or(RayTextError::NotSix)?;
        let is_ray = ray.iter().all(|v| v.is_finite()) && ray[3..].iter().any(|&v| v != 0.0);
        if is_ray { Ok(Self(ray)) } else { Err(RayTextError::NoRay) }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn parse(text: &str) -> Result<[f64; 6], RayTextError> {
        text.parse().map(|GivenRay(numbers)| numbers)
    }

    #[test]
    fn a_ray_far_from_the_origin_keeps_its_place_in_the_scene() {
        let scene = Scene { offset: DVec3::new(1e7, 0.0, -4096.0), ..Scene::default() };
        let ray: GivenRay = "10000000.125,1,-4095.9,0,0,-1".parse().expect("a ray");
        assert_eq!(ray.in_scene(&scene), Ray::new([0.125, 1.0, 0.1], [0.0, 0.0, -1.0]));
        // Without an offset, decimals are those of f32.
        assert_eq!(ray.in_scene(&Scene::default()).origin, [10_000_000.125, 1.0, -4095.9]);
    }

    #[test]
    fn decimals_and_bits_are_read_and_nothing_else() {
        assert_eq!(parse("0, 1,2.5,0x40a00000,-0,1e-3"), Ok([0.0, 1.0, 2.5, 5.0, -0.0, 1e-3]));
        for text in ["", "1,2,3", "1,2,3,4,5,x", "0xzz,0,0,0,0,1", "1,2,3,4,5,6,7"] {
            assert_eq!(parse(text), Err(RayTextError::NotSix), "{text}");
        }
        for text in ["0,0,0,0,0,0", "inf,0,0,0,0,1", "0,0,0,0,0,0x7fc00000"] {
            assert_eq!(parse(text), Err(RayTextError::NoRay), "{text}");
        }
    }
}
