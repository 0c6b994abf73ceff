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

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, Options};

    use super::super::tests::{CORNELL, TEAPOT, options, scene, traced, whole};
    use super::*;

    #[test]
    fn a_picture_of_the_walk_contains_its_cells_and_its_hit_and_little_else() {
        for (file, pixel) in [(CORNELL, [20, 40]), (TEAPOT, [32, 32]), (TEAPOT, [0, 0])] {
            for accelerator in [Accelerator::Grid, Accelerator::Bvh, Accelerator::None] {
                let scene = scene(file);
                let (trace, data) = traced(&scene, &Options { accelerator, ..options(&scene) }, pixel);
                let walk = whole(&trace, &data);
                let extent = walk.extent();
                let (low, high) = extent.iter().fold((extent[0], extent[0]), |(a, b), &p| (a.min(p), b.max(p)));
                let has = |p: DVec3| p.cmpge(low - 1e-9).all() && p.cmple(high + 1e-9).all();
                let corners = walk.cells.iter().flat_map(|cell| cell.bounds.corners());
                assert!(corners.chain(walk.hit.map(|hit| hit.point)).all(has), "{file} {accelerator:?}");
                assert!((high - low).length() > 0.0 && high.is_finite() && low.is_finite());
                if let (Some(hit), Accelerator::Grid) = (walk.hit, accelerator) {
                    // Not the whole grid: only what is along the ray, one cell wide on either side.
                    let way = walk.point(walk.inside.map_or(0.0, |[enter, _]| enter));
                    let (from, to) = (way.min(hit.point) - walk.cell_size, way.max(hit.point) + walk.cell_size);
                    assert!(
                        low.cmpge(from - 1e-6).all() && high.cmple(to + 1e-6).all(),
                        "{file}: {low} {high}, {from} {to}"
                    );
                }
            }
        }
    }
}
