//! What a picture of a walk has to contain.

use glam::DVec3;

use super::{Aabb, Structure, WalkGeometry};

/// Most boxes that are considered from either end of a walk.
const MOST: usize = 4096;

impl WalkGeometry {
    /// Corners of what the picture of the walk contains: the cells visited or the leaves entered, and the ray from where
    /// it enters the grid or BVH, or starts in it, to the hit or to where it leaves.
    #[must_use]
    pub fn extent(&self) -> Vec<DVec3> {
        let first = self.inside.map_or(0.0, |[enter, _]| enter);
        let first = self.cells.first().map_or(first, |cell| cell.t_in.min(first));
        let mut points = vec![self.point(first), self.point(self.end_t())];
        points.extend(self.hit.map(|hit| hit.point));
        let mut add = |bounds: &Aabb| points.extend(bounds.corners());
        match self.structure {
            Structure::Grid => ends(&self.cells).for_each(|cell| add(&cell.bounds)),
            Structure::Tree => {
                let leaves: Vec<_> = self.nodes.iter().filter(|node| node.is_leaf && node.is_met).collect();
                ends(&leaves).for_each(|node| add(&node.bounds));
            }
            Structure::Nothing => {}
        }
        points.retain(|point| point.is_finite());
        // A line or a point alone would fill the picture, whatever its size.
        let (low, high) = bounds_of(&points);
        let least = self.bounds.radius() * 0.05;
        if (high - low).length() < least || self.structure == Structure::Nothing {
            let center = (low + high) * 0.5;
            let half = least.max((high - low).length() * 0.1);
            points.extend([center - DVec3::splat(half), center + DVec3::splat(half)]);
        }
        points
    }

    /// Where the walk ends: the hit, or the end of its last cell.
    fn end_t(&self) -> f64 {
        match (self.structure, self.hit, self.cells.last()) {
            (Structure::Grid, None, Some(cell)) if self.is_over => cell.t_out,
            _ => self.last_t(),
        }
    }
}

/// The first and the last ones.
fn ends<T>(all: &[T]) -> impl Iterator<Item = &T> {
    let (first, rest) = all.split_at(all.len().min(MOST));
    first.iter().chain(&rest[rest.len().saturating_sub(MOST)..])
}

fn bounds_of(points: &[DVec3]) -> (DVec3, DVec3) {
    let first = points.first().copied().unwrap_or_default();
    points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)))
}
