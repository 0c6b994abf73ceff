//! Traced units: scene units times a power of two, so that the scene's extent lies in [1, 2).
//!
//! Multiplying by a power of two is exact, so a scene that is a million times smaller or larger gives the same hits,
//! bit for bit; only `t` and positions are scaled back when they are reported.

use glam::DVec3;
use raystep_scenes::{Bounds, Scene};

/// The power of two between scene units and traced units, and the scene's offset in its file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Units {
    exponent: i32,
    /// See [`Scene::offset`].
    pub offset: DVec3,
}

impl Units {
    /// Units in which the longest side of the scene's bounds is in [1, 2). A single point is measured by its distance
    /// from the origin instead, and an empty scene is not scaled.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        Self { offset: scene.offset, ..Self::of_bounds(&scene.bounds()) }
    }

    fn of_bounds(bounds: &Bounds) -> Self {
        if bounds.is_empty() {
            return Self::default();
        }
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let extent = (max - min).max_element();
        let size = if extent > 0.0 { extent } else { min.abs().max(max.abs()).max_element() };
        Self { exponent: if size > 0.0 { -floor_log2(size) } else { 0 }, ..Self::default() }
    }

    /// Traced units per scene unit.
    #[must_use]
    pub fn scale(self) -> f64 {
        exp2(self.exponent)
    }

    /// Scene units per traced unit.
    #[must_use]
    pub fn scene_units_per_stream_unit(self) -> f64 {
        exp2(-self.exponent)
    }

    /// A point in traced units, in the coordinates of the scene's file.
    #[must_use]
    pub fn in_file(self, traced: [f64; 3]) -> [f64; 3] {
        (self.offset + DVec3::from_array(traced) * self.scene_units_per_stream_unit()).to_array()
    }

    /// A coordinate in traced units: exact unless it falls below f32's smallest normal number.
    #[must_use]
    pub fn to_traced(self, value: f32) -> f32 {
        (f64::from(value) * self.scale()) as f32
    }

    /// As [`Self::to_traced`], from f64, rounded to f32.
    #[must_use]
    pub fn to_traced_f64(self, value: f64) -> f32 {
        (value * self.scale()) as f32
    }
}

/// Exponent of a positive, finite, normal f64: `2^e <= value < 2^(e+1)`.
#[must_use]
pub fn floor_log2(value: f64) -> i32 {
    ((value.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// 2^exponent, exact for every exponent that f64 has a normal number for.
#[must_use]
pub fn exp2(exponent: i32) -> f64 {
    f64::from_bits(((exponent.clamp(-1022, 1023) + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extent_lies_in_one_to_two_at_every_scale() {
        for k in -140..=120 {
            let size = (1.7 * exp2(k)) as f32;
            let bounds = Bounds { min: glam::Vec3::ZERO, max: glam::Vec3::new(size, size * 0.5, 0.0) };
            let traced = Units::of_bounds(&bounds).to_traced(size);
            assert!((1.0..2.0).contains(&traced), "2^{k}: {traced}");
        }
        assert_eq!(Units::of_bounds(&Bounds::EMPTY).scale(), 1.0);
    }

    #[test]
    fn points_are_reported_in_the_coordinates_of_the_file() {
        let triangles = vec![[[0.0; 3], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
        let scene = Scene { offset: DVec3::new(1e7, 0.0, -4096.0), ..Scene::from_triangles(triangles) };
        let units = Units::of(&scene);
        assert_eq!(units.scene_units_per_stream_unit(), 2.0);
        assert_eq!(units.in_file([1.5, 0.25, -0.125]), [1e7 + 3.0, 0.5, -4096.25]);
    }
}
