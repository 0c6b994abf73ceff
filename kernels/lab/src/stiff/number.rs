//! The stiffness number: the work that a structure makes of the place where a ray ends.
//!
//! A ray's work in a structure, in cells or nodes visited plus triangles tested, can be predicted from the structure
//! alone. It has two parts:
//!
//! - *At its end*: a ray that ends on a surface tests everything listed at that point. The expected work at a random
//!   point of a random triangle, found for [`POINTS`] points, is the stiffness number. For trees this is what Aila, Karras
//!   and Laine ("On quality metrics of bounding volume hierarchies", 2013) measure as end-point overlap, except that they
//!   weight triangles by area and leave out the triangle's own leaf: here each triangle counts the same, since rays are
//!   aimed at what is small and detailed.
//! - *Along the line*: a random line that meets a convex box meets another one inside it with a probability that is the
//!   ratio of their areas. The areas of all cells or nodes, weighted with their work and divided by the scene's, are the
//!   expected work of a line: for trees the surface area heuristic (Goldsmith and Salmon 1987; MacDonald and Booth
//!   1990), for grids the same sum (Cleary and Wyvill 1988). An empty cell that is skipped together with its neighbours
//!   up to chessboard distance d counts 1/d.
//!
//! Aila et al. fit the weights of both. Over the families, the end alone predicts the time of a ray about as well as their
//! sum, and is simpler; pages print the rank correlations of both. A tuned structure of an evenly filled scene has a
//! number below 10, and one that lists all of n triangles in one place about n. What depends on the rays, as grazing
//! angles and long walks do, is not in the number.

use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::constants::OUTSIDE;
use raystep_kernels::shared::irregular_walk::find;

use crate::rays::Random;
use crate::structure_stats::{GridStats, TreeStats, at_point, triangles_in};

/// Random points at which the work is counted.
pub const POINTS: u32 = 1024;

/// The predicted work of a ray, in cells or nodes visited plus triangles tested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Of a random line through the scene's box; `None` if the box has no area.
    pub line: Option<f64>,
    /// At a random point of a random triangle: the stiffness number.
    pub end: f64,
}

impl Predicted {
    /// The prediction for a plan's structure; without one, every triangle is tested. `None` without triangles.
    #[must_use]
    pub fn of(data: &SceneData, seed: u32) -> Option<Self> {
        let triangles = data.info.triangles;
        if triangles == 0 {
            return None;
        }
        let mut sum = 0;
        for i in 0..POINTS {
            let point = on_surface(data, &mut Random::of(i, seed));
            sum += match at_point(data, point) {
                Some([nodes, tests]) => nodes + tests,
                None if data.features.irregular => work_in_irregular(data, point),
                None if data.features.grid => {
                    1 + triangles_in(data, data.grid.cell_index(cell_at(data, point))).len() as u64
                }
                None => u64::from(triangles),
            };
        }
        let line = match TreeStats::of(data) {
            Some(tree) => tree.sah_cost,
            None if data.features.grid => line_through_grid(data),
            // The boxes of an irregular grid overlap: their areas do not tell how many a line visits.
            None if data.features.irregular => None,
            None => Some(f64::from(triangles)),
        };
        Some(Self { line, end: sum as f64 / f64::from(POINTS) })
    }
}

/// A random point in a random triangle, in traced units.
fn on_surface(data: &SceneData, random: &mut Random) -> [f64; 3] {
    let first = 9 * random.below(data.vertices.len() / 9);
    let (u, v) = random.in_triangle();
    [0, 1, 2].map(|axis| {
        let [a, b, c] = [0, 3, 6].map(|corner| f64::from(data.vertices[first + corner + axis]));
        a + (b - a) * u + (c - a) * v
    })
}

/// The cell that lists what is at a point, and the triangles set aside, which every ray tests.
fn work_in_irregular(data: &SceneData, point: [f64; 3]) -> u64 {
    let tests = |cell: u32| 1 + u64::from(data.list(cell).1);
    let cell = find(&data.grid, &data.irregular_map, cell_at(data, point));
    tests(cell) + if data.is_outside(OUTSIDE) { tests(OUTSIDE) } else { 0 }
}

fn cell_at(data: &SceneData, point: [f64; 3]) -> [i32; 3] {
    let grid = &data.grid;
    [0, 1, 2].map(|axis| {
        let along = (point[axis] - f64::from(grid.corner[axis])) / f64::from(grid.width[axis]);
        (along.floor().max(0.0) as i32).min((grid.cells[axis] - 1).max(0))
    })
}

/// Visits and tests of a random line through a grid.
fn line_through_grid(data: &SceneData) -> Option<f64> {
    let area = |[x, y, z]: [f64; 3]| x * y + y * z + z * x;
    let width = data.grid.width.map(f64::from);
    let whole = area([0, 1, 2].map(|axis| width[axis] * f64::from(data.grid.cells[axis])));
    let stats = GridStats::of(data)?;
    let cells = stats.cells_in_all();
    let visits = if data.grid_distances.is_empty() {
        cells as f64
    } else {
        (0..cells as u32).map(|cell| 1.0 / f64::from(data.empty_distance(cell).max(1))).sum()
    };
    (whole > 0.0).then(|| (visits + stats.references as f64) * area(width) / whole)
}

/// Spearman's rank correlation (1904); tied values share their mean rank. `None` for fewer than three pairs, or if one
/// side has a single value.
#[must_use]
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    if pairs.len() < 3 {
        return None;
    }
    let ranks = |of: fn(&(f64, f64)) -> f64| {
        let values: Vec<f64> = pairs.iter().map(of).collect();
        let rank = |v: f64| {
            let (below, equal) = values.iter().fold((0, 0), |(b, e), &o| (b + i32::from(o < v), e + i32::from(o == v)));
            f64::from(below) + f64::from(equal - 1) * 0.5
        };
        values.iter().map(|&v| rank(v)).collect::<Vec<f64>>()
    };
    let mean = (pairs.len() - 1) as f64 * 0.5;
    let (x, y) = (ranks(|p| p.0), ranks(|p| p.1));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let spread = (product(&x, &x) * product(&y, &y)).sqrt();
    (spread > 0.0).then(|| product(&x, &y) / spread)
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, GridSize, Limits, Options, Plan, RaySource};
    use raystep_scenes::{Scene, generate};

    use super::*;
    use crate::stability::make::scene_of;

    fn predicted(scene: &Scene, accelerator: Accelerator, grid: GridSize) -> Predicted {
        let options = Options { accelerator, grid, shade: false, ..Options::new(RaySource::Given(Vec::new())) };
        let (_, data) = Plan::new(scene, &options, &Limits::CPU).expect("a plan");
        Predicted::of(&data, 1).expect("triangles")
    }

    #[test]
    fn work_of_simple_structures_is_the_one_by_hand() {
        let sphere = generate::icosphere(3).expect("a sphere");
        // One cell lists all; every line through the box visits it.
        let one = predicted(&sphere, Accelerator::Grid, GridSize::Cells([1; 3]));
        assert_eq!((one.line, one.end), (Some(1281.0), 1281.0));
        let none = predicted(&sphere, Accelerator::None, GridSize::Auto);
        assert_eq!((none.line, none.end), (Some(1280.0), 1280.0));
        // Two triangles at opposite ends of a row of 100 cells: each lies in one cell.
        let triangle = |x: f32| [[x, 0.0, 0.0], [x + 0.1, 0.0, 1.0], [x, 1.0, 0.0]];
        let two =
            predicted(&scene_of(vec![triangle(0.0), triangle(99.9)]), Accelerator::Grid, GridSize::Cells([100, 1, 1]));
        assert_eq!(two.end, 2.0);
        let irregular = predicted(&sphere, Accelerator::Irregular, GridSize::Auto);
        assert!((2.0..20.0).contains(&irregular.end) && irregular.line.is_none(), "{irregular:?}");
        let bvh = predicted(&sphere, Accelerator::Bvh, GridSize::Auto);
        assert!((2.0..20.0).contains(&bvh.end) && bvh.line.is_some_and(|line| line < 40.0), "{bvh:?}");
        assert!(Predicted::of(&SceneData::default(), 1).is_none());
    }

    #[test]
    fn ranks_are_correlated_as_by_hand() {
        let rising = [(1.0, 2.0), (2.0, 40.0), (3.0, 41.0), (9.0, 1e9)];
        let of = |pairs: &[(f64, f64)]| rank_correlation(pairs).expect("a correlation");
        assert!((of(&rising) - 1.0).abs() < 1e-12);
        assert!((of(&rising.map(|(x, y)| (x, -y))) + 1.0).abs() < 1e-12);
        // Ranks 0 1 2 3 and 1 0 3 2: 1 - 6 (1 + 1 + 1 + 1) / (4 · 15).
        assert!((of(&[(1.0, 5.0), (2.0, 4.0), (3.0, 9.0), (4.0, 8.0)]) - 0.6).abs() < 1e-12);
        assert_eq!((rank_correlation(&rising[..2]), rank_correlation(&[(1.0, 2.0); 5])), (None, None));
    }
}
