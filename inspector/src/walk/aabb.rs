//! Boxes.

use glam::DVec3;
use raystep_kernels::shared::grid_walk::Grid;

use super::to_f64;

/// An axis-aligned box, traced units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lower corner.
    pub min: DVec3,
    /// Upper corner.
    pub max: DVec3,
}

impl Aabb {
    /// From two corners.
    #[must_use]
    pub fn of_f32(min: [f32; 3], max: [f32; 3]) -> Self {
        Self { min: to_f64(min), max: to_f64(max) }
    }

    /// The box of `count` cells starting at cell `first`.
    #[must_use]
    pub fn of_cells(grid: &Grid, first: [i32; 3], count: [i32; 3]) -> Self {
        let plane = |cell: [i32; 3]| to_f64(grid.corner) + to_f64(grid.width) * DVec3::from_array(cell.map(f64::from));
        let end = [0, 1, 2].map(|a| first[a].saturating_add(count[a]));
        Self { min: plane(first), max: plane(end) }
    }

    /// The box of triangles, nine floats each; the origin if there are none.
    #[must_use]
    pub fn of_vertices(vertices: &[f32]) -> Self {
        let (points, _) = vertices.as_chunks::<3>();
        let Some(&first) = points.first() else { return Self { min: DVec3::ZERO, max: DVec3::ZERO } };
        let (min, max) = points.iter().fold((first, first), |(min, max), p| {
            ([0, 1, 2].map(|a| min[a].min(p[a])), [0, 1, 2].map(|a| max[a].max(p[a])))
        });
        Self::of_f32(min, max)
    }

    /// Its centre.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Half its diagonal.
    #[must_use]
    pub fn radius(&self) -> f64 {
        (self.max - self.min).length() * 0.5
    }

    /// Its corners; bit `a` of the index selects the upper one along axis `a`.
    #[must_use]
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let upper = |axis: usize| i >> axis & 1 == 1;
            DVec3::select(glam::BVec3::new(upper(0), upper(1), upper(2)), self.max, self.min)
        })
    }

    /// Its edges.
    #[must_use]
    pub fn edges(&self) -> [[DVec3; 2]; 12] {
        let corners = self.corners();
        const EDGES: [[usize; 2]; 12] = [
            [0, 1],
            [2, 3],
            [4, 5],
            [6, 7], // along x
            [0, 2],
            [1, 3],
            [4, 6],
            [5, 7], // along y
            [0, 4],
            [1, 5],
            [2, 6],
            [3, 7], // along z
        ];
        EDGES.map(|[a, b]| [corners[a], corners[b]])
    }

    /// Its faces, each as two triangles.
    #[must_use]
    pub fn faces(&self) -> [[DVec3; 3]; 12] {
        let c = self.corners();
        const FACES: [[usize; 3]; 12] = [
            [0, 2, 6],
            [0, 6, 4],
            [1, 5, 7],
            [1, 7, 3],
            [0, 4, 5],
            [0, 5, 1],
            [2, 3, 7],
            [2, 7, 6],
            [0, 1, 3],
            [0, 3, 2],
            [4, 6, 7],
            [4, 7, 5],
        ];
        FACES.map(|face| face.map(|corner| c[corner]))
    }

    /// The t interval, from 0, in which a ray is inside; `None` if it misses.
    #[must_use]
    pub fn interval(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let (o, d, min, max) = (origin[axis], direction[axis], self.min[axis], self.max[axis]);
            if d == 0.0 {
                if o < min || o > max {
                    return None;
                }
                continue;
            }
            let (a, b) = ((min - o) / d, (max - o) / d);
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        (enter <= leave && leave.is_finite()).then_some([enter, leave])
    }
}
