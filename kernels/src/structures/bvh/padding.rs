//! By how much boxes are grown, and where.

use crate::shared::constants::BOX_PADDING;

/// How boxes are grown so that rounding cannot make a ray miss one whose triangle it hits.
///
/// The errors of the slab test and of the triangle test are proportional to distances from the ray's origin: at most
/// [`BOX_PADDING`], 64 roundings, times the largest distance along an axis to a corner of the triangle
/// (`docs/numerics.md`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Padding {
    /// By this distance when the tree is built, in traced units: [`BOX_PADDING`] times a bound on all distances in the
    /// scene. It costs nothing per ray, but in a scene with a large reach and small triangles it makes many boxes
    /// overlap.
    Fixed(f32),
    /// By [`BOX_PADDING`] times the distance to the box for each ray and box, when it is tested. A piece of a triangle
    /// may be nearer than the triangle's corners, by at most the triangle's extent, so its box is grown by that part
    /// when the tree is built; all other boxes are exact.
    PerRay,
}

impl From<f32> for Padding {
    fn from(growth: f32) -> Self {
        Self::Fixed(growth)
    }
}

/// A share of more than 1 in this many triangles that [`Padding::Fixed`] would make much larger is too many.
const FEW: usize = 64;

/// A box is much larger if it is grown by more than this part of its middle side: the longest one does not tell of
/// slivers side by side, and the shortest one is 0 in any plane across an axis.
const LARGER: f32 = 16.0;

impl Padding {
    /// The distance by which all boxes are grown when they are built.
    #[must_use]
    pub fn growth(self) -> f32 {
        match self {
            Self::Fixed(growth) => growth,
            Self::PerRay => 0.0,
        }
    }

    /// By how much a triangle's box is grown when the tree is built, given its longest side, and whether it was cut.
    pub(super) fn of_triangle(self, extent: f64, is_cut: bool) -> f64 {
        match self {
            Self::Fixed(growth) => f64::from(growth),
            // A little more than the product, which f64 rounds.
            Self::PerRay if is_cut => f64::from(BOX_PADDING) * extent * (1.0 + 2.0f64.powi(-40)),
            Self::PerRay => 0.0,
        }
    }

    /// `PerRay` if `growth` would make the boxes of many triangles much larger, else `Fixed`.
    #[must_use]
    pub fn suits(vertices: &[f32], growth: f32) -> Self {
        let is_enlarged = |triangle: &[f32]| {
            let [_, middle, longest] = sides(triangle);
            longest > 0.0 && middle < LARGER * growth
        };
        let parts = crate::numbers::parallel::map_ranges(vertices.len() / 9, 1 << 14, |range| {
            vertices[9 * range.start..9 * range.end].chunks_exact(9).filter(|triangle| is_enlarged(triangle)).count()
        });
        let enlarged: usize = parts.into_iter().sum();
        if enlarged > vertices.len() / 9 / FEW { Self::PerRay } else { Self::Fixed(growth) }
    }
}

/// The sides of a triangle's box, ascending.
fn sides(triangle: &[f32]) -> [f32; 3] {
    let mut sides = [0, 1, 2].map(|axis| {
        let [a, b, c] = [0, 3, 6].map(|corner| triangle[corner + axis]);
        a.max(b).max(c) - a.min(b).min(c)
    });
    sides.sort_by(f32::total_cmp);
    sides
}

/// The longest side of a triangle's box.
pub(super) fn extent(triangle: &[f32]) -> f32 {
    sides(triangle)[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of triangles with legs of length `side`.
    fn row(count: usize, side: f32) -> Vec<f32> {
        (0..count).flat_map(|i| [i as f32, 0.0, 0.0, i as f32 + side, 0.0, 0.0, i as f32, side, 0.0]).collect()
    }

    #[test]
    fn boxes_are_grown_for_each_ray_if_many_would_be_much_larger() {
        let growth = 1.0 / 1024.0;
        let fixed = Padding::Fixed(growth);
        assert_eq!(Padding::suits(&row(640, 0.25), growth), fixed);
        assert_eq!(Padding::suits(&row(640, 1.0 / 128.0), growth), Padding::PerRay);
        // Few small ones do not matter, nor do those without an extent, which no ray hits.
        let mixed = |small: usize, side: f32| [row(640 - small, 0.25), row(small, side)].concat();
        assert_eq!(Padding::suits(&mixed(10, 1.0 / 128.0), growth), fixed);
        assert_eq!(Padding::suits(&mixed(11, 1.0 / 128.0), growth), Padding::PerRay);
        assert_eq!(Padding::suits(&mixed(600, 0.0), growth), fixed);
        assert_eq!(Padding::suits(&[], growth), fixed);
        let mut slivers = row(640, 0.25);
        slivers.iter_mut().skip(7).step_by(9).for_each(|y| *y /= 64.0);
        assert_eq!(Padding::suits(&slivers, growth), Padding::PerRay);
    }

    #[test]
    fn only_pieces_are_grown_when_they_are_built() {
        assert_eq!(Padding::PerRay.of_triangle(0.5, false), 0.0);
        let piece = Padding::PerRay.of_triangle(0.5, true);
        assert!(piece >= 2.0f64.powi(-19) && piece < 2.0f64.powi(-19) * 1.001, "{piece:e}");
        assert_eq!(Padding::Fixed(0.25).of_triangle(0.5, true), 0.25);
    }
}
