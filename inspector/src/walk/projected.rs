//! The walk seen along one axis, as in the paper's Figure 3: squares and a line.

use glam::{DVec2, DVec3};

use super::unfolded::letters;
use super::{Outcome, Structure, WalkGeometry};

/// A column of cells, or a node's box, seen along the projection axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Square {
    /// Lower corner.
    pub min: DVec2,
    /// Upper corner.
    pub max: DVec2,
    /// Indices of the visits to its cells or node, in order.
    pub visits: Vec<usize>,
    /// Letters of the first visit, see [`letters`].
    pub letters: String,
    /// Whether the ray is in one of them.
    pub is_current: bool,
}

/// A tested triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectedTriangle {
    /// Index into [`WalkGeometry::tested`].
    pub test: usize,
    /// Its corners.
    pub corners: [DVec2; 3],
    /// The result of its test.
    pub outcome: Outcome,
}

/// The walk in two dimensions, traced units; the first axis points right and the second up.
#[derive(Clone, Debug, PartialEq)]
pub struct Projected {
    /// The two axes along which the ray moves most, the lower one first.
    pub axes: [usize; 2],
    /// The visible region: the squares, the ray's part among them, and one more cell on each side.
    pub min: DVec2,
    /// Its upper corner.
    pub max: DVec2,
    /// The grid's lines within it, per axis.
    pub lines: [Vec<f64>; 2],
    /// The squares, in the order of their first visits.
    pub squares: Vec<Square>,
    /// Where the ray enters the picture, or starts, and where it ends.
    pub ray: [DVec2; 2],
    /// The ray's current position.
    pub at: DVec2,
    /// Where the ray crosses planes of the two axes, with the axis.
    pub crossings: Vec<(DVec2, usize)>,
    /// The triangles tested, each once with the best outcome.
    pub triangles: Vec<ProjectedTriangle>,
    /// The nearest hit so far.
    pub hit: Option<DVec2>,
}

/// Most grid lines per axis; more would become a grey area.
const MOST_LINES: f64 = 256.0;

impl Projected {
    /// Projects a walk.
    #[must_use]
    pub fn new(walk: &WalkGeometry) -> Self {
        let axes = most_moving(walk.direction);
        let flat = |v: DVec3| DVec2::new(v[axes[0]], v[axes[1]]);
        let squares = squares(walk, axes);
        let hit = walk.hit.map(|hit| flat(hit.point));
        let first = walk.inside.map_or(0.0, |[enter, _]| enter);
        // In a grid, no farther than the visible cells.
        let last = match (walk.structure, walk.hit, walk.cells.last()) {
            (Structure::Grid, Some(hit), Some(cell)) => hit.t.max(cell.t_out),
            (Structure::Grid, None, Some(cell)) => cell.t_out,
            _ => walk.last_t(),
        };
        let [from, to] = [first, last].map(|t| flat(walk.point(t)));
        let points = squares.iter().flat_map(|s| [s.min, s.max]).chain([from, to]).chain(hit);
        let (low, high) = points.fold((from, from), |(low, high), p| (low.min(p), high.max(p)));
        let margin = match walk.structure {
            Structure::Grid => flat(walk.cell_size),
            _ => DVec2::splat((high - low).max_element() * 0.05),
        };
        let (mut min, mut max) = (low - margin, high + margin);
        if walk.structure == Structure::Grid && !squares.is_empty() {
            (min, max) = (min.max(flat(walk.bounds.min)), max.min(flat(walk.bounds.max)));
            (min, max) = (min.min(from.min(to)), max.max(from.max(to)));
        }
        let lines = [0, 1].map(|a| lines(walk, axes[a], min[a], max[a]));
        // Starts a little earlier, to show where the ray comes from.
        let before = (max - min).length() * 0.08 / flat(walk.direction).length().max(f64::MIN_POSITIVE);
        let start = flat(walk.point((first - before).max(0.0)));
        let room = DVec2::splat((max - min).max_element() * 0.01);
        Self {
            axes,
            min: min.min(start - room),
            max: max.max(start + room),
            lines,
            squares,
            ray: [start, to],
            at: flat(walk.current_point()),
            crossings: (walk.crossings.iter())
                .filter(|crossing| axes.contains(&crossing.axis))
                .map(|crossing| (flat(crossing.point), crossing.axis))
                .collect(),
            triangles: triangles(walk, flat),
            hit,
        }
    }
}

/// The two axes with the largest components, the lower one first.
fn most_moving(direction: DVec3) -> [usize; 2] {
    let size = direction.abs();
    let least = (0..3).rev().min_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(2);
    [[1, 2], [0, 2], [0, 1]][least]
}

fn squares(walk: &WalkGeometry, axes: [usize; 2]) -> Vec<Square> {
    let flat = |v: DVec3| DVec2::new(v[axes[0]], v[axes[1]]);
    let mut squares: Vec<Square> = Vec::new();
    let mut push = |square: Square| {
        // Cells of one column are consecutive; a walk never returns to a square.
        match squares.last_mut().filter(|last| last.min == square.min && last.max == square.max) {
            Some(last) => {
                last.is_current |= square.is_current;
                last.visits.extend(square.visits);
            }
            None => squares.push(square),
        }
    };
    for (i, cell) in walk.cells.iter().enumerate() {
        let (min, max) = (flat(cell.bounds.min), flat(cell.bounds.max));
        push(Square { min, max, visits: vec![i], letters: letters(i), is_current: cell.is_current });
    }
    for (i, node) in walk.nodes.iter().enumerate().filter(|(_, node)| node.is_met) {
        let (min, max) = (flat(node.bounds.min), flat(node.bounds.max));
        let is_current = walk.current_node == Some(node.node);
        push(Square { min, max, visits: vec![i], letters: letters(i), is_current });
    }
    squares
}

fn lines(walk: &WalkGeometry, axis: usize, min: f64, max: f64) -> Vec<f64> {
    let (corner, width) = (walk.bounds.min[axis], walk.cell_size[axis]);
    let count = walk.grid_cells[axis];
    if walk.structure != Structure::Grid || width <= 0.0 || (max - min) / width > MOST_LINES {
        return Vec::new();
    }
    (0..=count).map(|i| corner + width * f64::from(i)).filter(|line| (min..=max).contains(line)).collect()
}

fn triangles(walk: &WalkGeometry, flat: impl Fn(DVec3) -> DVec2) -> Vec<ProjectedTriangle> {
    let project = |test: usize| {
        let tested = walk.tested.get(test)?;
        Some(ProjectedTriangle { test, corners: tested.corners.map(&flat), outcome: tested.outcome })
    };
    walk.distinct_tested().into_iter().filter_map(project).collect()
}
