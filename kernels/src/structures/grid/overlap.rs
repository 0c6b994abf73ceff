//! Which cells a triangle overlaps: the separating axes of Schwarz and Seidel (2010), whose per-triangle part is
//! computed once. In f64, whose rounding errors are far below the cells' growth.

use glam::DVec3;

use crate::shared::grid_walk::Grid;

/// A triangle prepared for tests against cells of one size, and the cells that its bounding box touches.
pub(crate) struct Overlap {
    /// First cell that the triangle's bounding box touches, per axis.
    pub(crate) low: [i32; 3],
    /// Last cell that it touches.
    pub(crate) high: [i32; 3],
    axes: Axes,
}

/// A triangle prepared for tests against cells of one size, except along the axes of space.
pub(crate) struct Axes {
    corner: [f64; 3],
    width: [f64; 3],
    normal: DVec3,
    plane: f64,
    plane_reach: f64,
    edges: [[[f64; 3]; 3]; 3],
}

/// Values shared by the cells of a row along x.
struct Row {
    cy: f64,
    cz: f64,
    /// The plane's expression without its x term.
    plane: f64,
}

/// The two axes that remain when one is projected away.
const OTHER: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

impl Overlap {
    /// Prepares `triangle` (traced units) for the cells of `grid`, each grown by `growth` on all sides.
    pub(crate) fn new(grid: &Grid, growth: f64, triangle: &[f32]) -> Self {
        let axes = Axes::new(grid, growth, triangle);
        let [min, max] = grown_bounds(growth, triangle);
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for a in 0..3 {
            // `as` saturates, so a cell far outside is clamped instead of wrapping; it truncates, which equals floor
            // where it matters, and needs no call on processors without a floor instruction.
            let cell = |v: f64| (((v - axes.corner[a]) / axes.width[a]) as i32).clamp(0, grid.cells[a] - 1);
            (low[a], high[a]) = (cell(min[a]), cell(max[a]));
        }
        Self { low, high, axes }
    }

    /// Calls `f` with every cell that the triangle overlaps.
    pub(super) fn for_cells(&self, mut f: impl FnMut([i32; 3])) {
        if self.low == self.high {
            return f(self.low);
        }
        for z in self.low[2]..=self.high[2] {
            let cz = self.axes.center(2, z);
            for y in self.low[1]..=self.high[1] {
                let Some(row) = self.axes.row(self.axes.center(1, y), cz) else { continue };
                for x in self.low[0]..=self.high[0] {
                    if self.axes.meets(&row, x) {
                        f([x, y, z]);
                    }
                }
            }
        }
    }

    /// As [`Axes::span_mask`]: the same test as in [`for_cells`](Self::for_cells), even if the triangle's box is a single
    /// cell.
    pub(crate) fn span_mask(&self, first: [i32; 3], cells: u32) -> u32 {
        self.axes.span_mask(first, cells)
    }
}

/// The corners of a triangle's bounding box, grown on all sides.
fn grown_bounds(growth: f64, triangle: &[f32]) -> [[f64; 3]; 2] {
    let of = |a: usize, pick: fn(f64, f64) -> f64| {
        pick(pick(f64::from(triangle[a]), f64::from(triangle[a + 3])), f64::from(triangle[a + 6]))
    };
    [[0, 1, 2].map(|a| of(a, f64::min) - growth), [0, 1, 2].map(|a| of(a, f64::max) + growth)]
}

/// Which halves of a cell a triangle overlaps: a bit for each of the eight, x fastest. `cell` is of the grid whose cells
/// are twice as wide along each axis as those of `grid`.
pub(crate) fn halves(grid: &Grid, growth: f64, triangle: &[f32], cell: [i32; 3]) -> u32 {
    let axes = Axes::new(grid, growth, triangle);
    let [min, max] = grown_bounds(growth, triangle);
    // Touching counts.
    let is_near = [0, 1, 2].map(|a| {
        let plane = |half: i32| axes.corner[a] + f64::from(2 * cell[a] + half) * axes.width[a];
        [0, 1].map(|half| plane(half) <= max[a] && plane(half + 1) >= min[a])
    });
    let mut mask = 0;
    for (y, z) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        if is_near[1][y] && is_near[2][z] {
            let row = axes.span_mask([2 * cell[0], 2 * cell[1] + y as i32, 2 * cell[2] + z as i32], 2);
            let along = u32::from(is_near[0][0]) | u32::from(is_near[0][1]) << 1;
            mask |= (row & along) << (2 * y + 4 * z);
        }
    }
    mask
}

impl Axes {
    /// Prepares `triangle` (traced units) for the cells of `grid`, each grown by `growth` on all sides.
    fn new(grid: &Grid, growth: f64, triangle: &[f32]) -> Self {
        let p = [0, 3, 6].map(|c| DVec3::from([0, 1, 2].map(|a| f64::from(triangle[c + a]))));
        let corner = grid.corner.map(f64::from);
        let width = grid.width.map(f64::from);
        let half = width.map(|w| w * 0.5 + growth);
        let edge = [p[1] - p[0], p[2] - p[1], p[0] - p[2]];
        let normal = edge[0].cross(edge[1]);
        let mut edges = [[[0.0; 3]; 3]; 3];
        for axis in 0..3 {
            let [i, j] = OTHER[axis];
            let flip = if normal[axis] >= 0.0 { 1.0 } else { -1.0 };
            for e in 0..3 {
                // Inward normal of the projected edge, and the distance of the box's farthest corner.
                let (ni, nj) = (-edge[e][j] * flip, edge[e][i] * flip);
                let offset = -(ni * p[e][i] + nj * p[e][j]) + ni.abs() * half[i] + nj.abs() * half[j];
                edges[axis][e] = [ni, nj, offset];
            }
        }
        let plane_reach = (0..3).map(|a| normal[a].abs() * half[a]).sum();
        Self { corner, width, normal, plane: -normal.dot(p[0]), plane_reach, edges }
    }

    /// Which of up to 32 cells along x, from `first` on, the triangle overlaps: one bit each.
    fn span_mask(&self, first: [i32; 3], cells: u32) -> u32 {
        let Some(row) = self.row(self.center(1, first[1]), self.center(2, first[2])) else { return 0 };
        (0..cells.min(32)).fold(0, |mask, k| mask | u32::from(self.meets(&row, first[0].wrapping_add(k as i32))) << k)
    }

    /// Centre of a cell.
    #[inline]
    fn center(&self, axis: usize, cell: i32) -> f64 {
        self.corner[axis] + (f64::from(cell) + 0.5) * self.width[axis]
    }

    /// `None` if no cell of the row overlaps: the projection along x is the same for all of them.
    #[inline]
    fn row(&self, cy: f64, cz: f64) -> Option<Row> {
        if !self.covers(0, cy, cz) {
            return None;
        }
        Some(Row { cy, cz, plane: self.normal.y * cy + self.normal.z * cz + self.plane })
    }

    /// Whether the cell at x in a row overlaps.
    #[inline]
    fn meets(&self, row: &Row, x: i32) -> bool {
        let cx = self.center(0, x);
        let is_near = (self.normal.x * cx + row.plane).abs() <= self.plane_reach;
        is_near && self.covers(1, row.cz, cx) && self.covers(2, cx, row.cy)
    }

    /// Whether triangle and grown cell overlap when projected along an axis; touching counts.
    fn covers(&self, axis: usize, ci: f64, cj: f64) -> bool {
        self.edges[axis].iter().all(|&[ni, nj, offset]| ni * ci + nj * cj + offset >= 0.0)
    }
}
