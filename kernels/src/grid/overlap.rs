//! Which cells a triangle overlaps: the separating axes of Schwarz and Seidel (2010), whose per-triangle
//! part is worked out once. In f64, whose rounding is far below what the cells are grown by.

use crate::shared::grid_walk::Grid;

/// A triangle prepared against boxes of one size.
pub(super) struct Overlap {
    /// First and last cell that the triangle's own box touches, per axis.
    pub(super) low: [i32; 3],
    pub(super) high: [i32; 3],
    corner: [f64; 3],
    width: [f64; 3],
    normal: [f64; 3],
    plane: f64,
    plane_reach: f64,
    edges: [[[f64; 3]; 3]; 3],
}

/// The two axes that remain when one is projected away.
const OTHER: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

impl Overlap {
    /// Prepares `triangle` (traced units) against the cells of `grid`, each grown by `growth` on all sides.
    pub(super) fn new(grid: &Grid, growth: f64, triangle: &[f32]) -> Self {
        let p: [[f64; 3]; 3] = [0, 3, 6].map(|c| [0, 1, 2].map(|a| f64::from(triangle[c + a])));
        let corner = grid.corner.map(f64::from);
        let width = grid.width.map(f64::from);
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for a in 0..3 {
            let min = p[0][a].min(p[1][a]).min(p[2][a]) - growth;
            let max = p[0][a].max(p[1][a]).max(p[2][a]) + growth;
            // `as` saturates, so a cell far outside is clamped, not wrapped.
            low[a] = (((min - corner[a]) / width[a]).floor() as i32).clamp(0, grid.cells[a] - 1);
            high[a] = (((max - corner[a]) / width[a]).floor() as i32).clamp(0, grid.cells[a] - 1);
        }
        let half = width.map(|w| w * 0.5 + growth);
        let edge = [sub(p[1], p[0]), sub(p[2], p[1]), sub(p[0], p[2])];
        let normal = cross(edge[0], edge[1]);
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
        Self { low, high, corner, width, normal, plane: -dot(normal, p[0]), plane_reach, edges }
    }

    /// Whether the triangle's box touches one cell only.
    pub(super) fn is_single(&self) -> bool {
        self.low == self.high
    }

    /// Calls `f` with every cell that the triangle overlaps.
    pub(super) fn for_cells(&self, mut f: impl FnMut([i32; 3])) {
        for z in self.low[2]..=self.high[2] {
            for y in self.low[1]..=self.high[1] {
                for x in self.low[0]..=self.high[0] {
                    if self.overlaps([x, y, z]) {
                        f([x, y, z]);
                    }
                }
            }
        }
    }

    /// Whether the triangle overlaps a cell that its box touches. Touching counts.
    fn overlaps(&self, cell: [i32; 3]) -> bool {
        let center = [0, 1, 2].map(|a| self.corner[a] + (f64::from(cell[a]) + 0.5) * self.width[a]);
        if (dot(self.normal, center) + self.plane).abs() > self.plane_reach {
            return false;
        }
        self.edges.iter().zip(OTHER).all(|(edges, [i, j])| {
            edges.iter().all(|&[ni, nj, offset]| ni * center[i] + nj * center[j] + offset >= 0.0)
        })
    }
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
