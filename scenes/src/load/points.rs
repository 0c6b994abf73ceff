//! Positions before they are placed: as exact as the file has them, in as little memory as that takes.

use glam::DVec3;

/// A list of points.
pub(crate) enum Points {
    /// 32-bit floats of the file.
    Single(Vec<[f32; 3]>),
    /// Integers, and what morph targets and skins have moved.
    Double(Vec<[f64; 3]>),
}

impl Points {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Single(points) => points.len(),
            Self::Double(points) => points.len(),
        }
    }

    #[inline]
    pub(super) fn get(&self, i: usize) -> Option<DVec3> {
        match self {
            Self::Single(points) => points.get(i).map(|[x, y, z]| DVec3::new((*x).into(), (*y).into(), (*z).into())),
            Self::Double(points) => points.get(i).map(|[x, y, z]| DVec3::new(*x, *y, *z)),
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = DVec3> {
        (0..self.len()).map_while(|i| self.get(i))
    }
}
