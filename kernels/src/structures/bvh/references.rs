//! References: the triangles, or pieces of triangles, that leaves list, each with its exact box.

use glam::Vec3A;
use obvhs::aabb::Aabb;

use super::padding::{Padding, extent};
use super::{BvhError, MAX_COORDINATE, MAX_TRIANGLES, down, up};
use crate::numbers::parallel::{for_chunks, map_ranges};

/// Triangles per task.
const CHUNK: usize = 1 << 14;

/// Boxes and the triangles they belong to, with the same indices.
pub(super) struct References {
    /// Of triangles, exact. A piece's box contains its part of the triangle, grown only by [`grow_pieces`](Self::grow_pieces).
    pub(super) boxes: Vec<Aabb>,
    pub(super) triangles: Vec<u32>,
}

impl References {
    /// One reference per triangle.
    pub(super) fn of(vertices: &[f32]) -> Result<Self, BvhError> {
        let count = vertices.len() / 9;
        if count as u64 > MAX_TRIANGLES {
            return Err(BvhError::TooManyTriangles { triangles: count as u64 });
        }
        let bad = map_ranges(count, CHUNK, |range| {
            vertices[9 * range.start..9 * range.end]
                .iter()
                .position(|v| !(-MAX_COORDINATE..=MAX_COORDINATE).contains(v))
                .map(|at| (range.start + at / 9) as u32)
        });
        if let Some(triangle) = bad.into_iter().flatten().next() {
            return Err(BvhError::Corner { triangle });
        }
        let mut boxes = vec![Aabb::default(); count];
        for_chunks(&mut boxes, CHUNK, |first, piece| {
            for (i, bounds) in piece.iter_mut().enumerate() {
                let [a, b, c] = corners(vertices, (first + i) as u32);
                *bounds = Aabb::new(a.min(b).min(c), a.max(b).max(c));
            }
        });
        Ok(Self { boxes, triangles: (0..count as u32).collect() })
    }

    /// Grows the boxes of triangles that were cut, see [`Padding::PerRay`].
    pub(super) fn grow_pieces(&mut self, vertices: &[f32]) {
        let mut pieces = vec![0u32; vertices.len() / 9];
        for &triangle in &self.triangles {
            pieces[triangle as usize] += 1;
        }
        for (bounds, &triangle) in self.boxes.iter_mut().zip(&self.triangles) {
            if pieces[triangle as usize] > 1 {
                let extent = extent(&vertices[9 * triangle as usize..9 * triangle as usize + 9]);
                let growth = Padding::PerRay.of_triangle(f64::from(extent), true);
                let [min, max] = Bounds::of(bounds).grown(growth);
                *bounds = Aabb::new(Vec3A::from(min.map(down)), Vec3A::from(max.map(up)));
            }
        }
    }

    /// Lower and upper corner of a reference's box.
    pub(super) fn bounds(&self, reference: u32) -> Bounds {
        Bounds::of(&self.boxes[reference as usize])
    }
}

/// The corners of a triangle, which must exist.
pub(super) fn corners(vertices: &[f32], triangle: u32) -> [Vec3A; 3] {
    let first = 9 * triangle as usize;
    let v = &vertices[first..first + 9];
    [0, 3, 6].map(|c| Vec3A::new(v[c], v[c + 1], v[c + 2]))
}

/// An exact box: lower and upper corner.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) min: [f32; 3],
    pub(super) max: [f32; 3],
}

impl Bounds {
    pub(super) const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    pub(super) fn of(aabb: &Aabb) -> Self {
        Self { min: aabb.min.to_array(), max: aabb.max.to_array() }
    }

    pub(super) fn join(&mut self, other: &Self) {
        for a in 0..3 {
            self.min[a] = self.min[a].min(other.min[a]);
            self.max[a] = self.max[a].max(other.max[a]);
        }
    }

    pub(super) fn half_area(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|a| f64::from(self.max[a]) - f64::from(self.min[a]));
        x * y + y * z + z * x
    }

    /// Lower and upper corner of the grown box.
    pub(super) fn grown(&self, growth: f64) -> [[f64; 3]; 2] {
        [self.min.map(|v| f64::from(v) - growth), self.max.map(|v| f64::from(v) + growth)]
    }
}
