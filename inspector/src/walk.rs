//! The walk of one ray as geometry: the cells, nodes and triangles of the first rows of a [`Trace`], in traced units,
//! for any kind of picture.
//!
//! The device's decisions are taken from its streams (which cell came next, the tmax that selected it, which triangle
//! was nearest); only what the streams do not contain is computed here, in f64: where a ray enters a box, and where it
//! meets the plane of a triangle that it missed.

mod aabb;
mod both;
mod cells;
mod events;
mod framing;
mod light;
mod nodes;
mod projected;
mod scale;
mod tested;
mod unfolded;
mod why;

use std::ops::Range;

use glam::DVec3;
use raystep_kernels::export::trace::{RayState, Trace, TraceRow};
use raystep_kernels::program::Path;
use raystep_kernels::programs::closest_hit::states;
use raystep_kernels::programs::photons::PROGRAM;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::constants::INF;

pub use aabb::Aabb;
pub use both::{Both, Work};
pub use cells::{CellVisit, Crossing, Entry};
pub use events::{Event, EventKind, events, last_row_of_ray, next_event, previous_event, row_after_passes};
pub use light::{Branch, branches};
pub use nodes::NodeVisit;
pub(crate) use nodes::{above, leaf_of};
pub use projected::{Projected, ProjectedTriangle, Square};
pub use scale::Ticks;
pub use tested::{Outcome, TestedTriangle};
pub use unfolded::{Spacing, Strip, StripCell, StripNode, StripTest, letters};
pub use why::Why;

/// The names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// The structure that the ray traverses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// The cells of a uniform or irregular grid.
    Grid,
    /// The nodes of a BVH.
    Tree,
    /// No structure: every triangle is tested.
    Nothing,
}

/// The nearest hit so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestHit {
    /// The triangle.
    pub triangle: u32,
    /// Its t.
    pub t: f64,
    /// Its position.
    pub point: DVec3,
    /// Weights of vertices 1 and 2.
    pub barycentric: [f64; 2],
    /// Its vertices.
    pub corners: [DVec3; 3],
}

/// The walk of a ray up to and including one row of its trace.
#[derive(Clone, Debug, PartialEq)]
pub struct WalkGeometry {
    /// The structure that the ray traverses.
    pub structure: Structure,
    /// The row; the last one if the trace has fewer, `None` if it has none.
    pub row: Option<usize>,
    /// The ray's origin.
    pub origin: DVec3,
    /// The ray's direction.
    pub direction: DVec3,
    /// The box of the grid, of the BVH's root, or of all triangles.
    pub bounds: Aabb,
    /// The t interval in which the ray is in `bounds`, from 0.
    pub inside: Option<[f64; 2]>,
    /// Size of a cell, of the top level in an irregular grid; zero without a grid.
    pub cell_size: DVec3,
    /// Such cells along each axis; zero without a grid.
    pub grid_cells: [i32; 3],
    /// Whether a pass may take several steps: then a leap need not be over empty cells.
    pub has_many_steps: bool,
    /// The cells visited, in order. The last is the current one, unless the ray has left the grid.
    pub cells: Vec<CellVisit>,
    /// The planes crossed between them, in order.
    pub crossings: Vec<Crossing>,
    /// The nodes whose boxes were tested, in order.
    pub nodes: Vec<NodeVisit>,
    /// The current node.
    pub current_node: Option<u32>,
    /// Its box.
    pub current_box: Option<Aabb>,
    /// The triangles tested, in order.
    pub tested: Vec<TestedTriangle>,
    /// The nearest hit so far.
    pub hit: Option<NearestHit>,
    /// Progress of the ray: the t at which it entered the current cell or node, or at which the walk ended.
    pub t: f64,
    /// Whether the walk has ended.
    pub is_over: bool,
}

impl WalkGeometry {
    /// The walk, up to and including row `row` of the trace, of the ray that the pixel has there.
    #[must_use]
    pub fn new(trace: &Trace, data: &SceneData, row: usize) -> Self {
        let row = trace.rows.len().checked_sub(1).map(|last| row.min(last));
        let rows = row.map_or(&[][..], |row| &trace.rows[..=row]);
        let mut walk = Self::before_the_walk(data, rows.last().map(|row| &row.after), row);
        let mut before = None;
        for (i, row) in
            rows.iter().enumerate().filter(|(_, row)| rows.last().is_some_and(|last| is_same_ray(row, last)))
        {
            match walk.structure {
                Structure::Grid => walk.move_to_cell(data, i, row, before),
                Structure::Tree => walk.move_to_node(data, i, row, before),
                Structure::Nothing => {}
            }
            walk.test_triangle(data, i, row, before);
            before = Some(&row.after);
        }
        walk.hit = rows.last().and_then(|row| nearest_hit(data, &row.after));
        walk.t = walk.how_far();
        walk
    }

    /// The point of the ray at t.
    #[must_use]
    pub fn point(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The ray's current position.
    #[must_use]
    pub fn current_point(&self) -> DVec3 {
        self.point(self.t)
    }

    /// The current cell.
    #[must_use]
    pub fn current_cell(&self) -> Option<&CellVisit> {
        self.cells.last().filter(|cell| cell.is_current)
    }

    /// Where the ray would leave its cell along each axis: the tmax values that the next step compares, unless it skips
    /// empty cells.
    #[must_use]
    pub fn next_crossings(&self) -> Vec<Crossing> {
        let Some(cell) = self.current_cell() else { return Vec::new() };
        let from = self.cells.len() - 1;
        (0..3)
            .filter_map(|axis| Some(Crossing { from, axis, t: cell.tmax[axis]?, point: self.point(cell.tmax[axis]?) }))
            .collect()
    }

    /// The last t that a picture of the ray must include: the hit, or where the ray leaves the scene.
    #[must_use]
    pub fn last_t(&self) -> f64 {
        let crossed = self.crossings.last().map_or(0.0, |crossing| crossing.t);
        let leaves = self.inside.map_or(0.0, |[_, leave]| leave);
        let last = if self.is_over { self.hit.map_or(leaves, |hit| hit.t) } else { leaves };
        if last.max(crossed) > 0.0 {
            return last.max(crossed);
        }
        // A ray that misses the scene: on to the point beside it.
        let length = self.direction.length();
        if length > 0.0 { (self.bounds.center() - self.origin).length() / length } else { 0.0 }
    }

    fn before_the_walk(data: &SceneData, ray: Option<&RayState>, row: Option<usize>) -> Self {
        let features = &data.features;
        let has_cells = has_cells(data);
        let structure = match (has_cells, features.bvh) {
            (true, _) => Structure::Grid,
            (_, true) => Structure::Tree,
            _ => Structure::Nothing,
        };
        let bounds = match (structure, data.bvh_nodes.first()) {
            (Structure::Grid, _) => Aabb::of_cells(&data.grid, [0; 3], data.grid.cells),
            (Structure::Tree, Some(root)) if data.info.triangles > 0 => Aabb::of_f32(root.min, root.max),
            _ => Aabb::of_vertices(&data.vertices),
        };
        let has_grid = structure == Structure::Grid;
        // Of an irregular grid, these are the cells of its top level; a uniform one has no others.
        let levels = data.grid.levels.min(30);
        let [origin, direction] = ray.map_or([DVec3::ZERO; 2], |ray| [ray.origin, ray.direction].map(to_f64));
        Self {
            structure,
            row,
            origin,
            direction,
            bounds,
            inside: bounds.interval(origin, direction),
            cell_size: if has_grid { to_f64(data.grid.width) * f64::from(1 << levels) } else { DVec3::ZERO },
            grid_cells: if has_grid { data.grid.cells.map(|n| n >> levels) } else { [0; 3] },
            has_many_steps: features.many_steps,
            cells: Vec::new(),
            crossings: Vec::new(),
            nodes: Vec::new(),
            current_node: None,
            current_box: None,
            tested: Vec::new(),
            hit: None,
            t: 0.0,
            is_over: ray.is_some_and(|ray| states::ALL.is_decided(ray.tag)),
        }
    }

    fn how_far(&self) -> f64 {
        if self.is_over {
            let left = self.crossings.last().map(|crossing| crossing.t);
            let leaves = self.inside.map(|[_, leave]| leave);
            return self.hit.map(|hit| hit.t).or(left).or(leaves).unwrap_or(0.0);
        }
        match self.structure {
            Structure::Grid => self.cells.last().map_or(0.0, |cell| cell.t_in),
            Structure::Tree => {
                let inside = self.current_box.and_then(|bounds| bounds.interval(self.origin, self.direction));
                let last_met = self.nodes.iter().rev().find_map(|node| node.inside.filter(|_| node.is_met));
                inside.or(last_met).map_or(0.0, |[enter, _]| enter)
            }
            Structure::Nothing => self.hit.map_or(0.0, |hit| hit.t),
        }
    }
}

/// The triangles that a cell or leaf lists; all of them without a structure.
pub fn listed(data: &SceneData, cell_or_node: u32) -> impl Iterator<Item = u32> {
    list(data, cell_or_node).map(|place| {
        if data.features.irregular {
            return data.irregular_items.get(place as usize).map_or(u32::MAX, |_| data.listed(place));
        }
        let items = match (data.features.grid, data.features.bvh) {
            (true, _) => &data.grid_items,
            (_, true) => &data.bvh_items,
            _ => return place,
        };
        items.get(place as usize).copied().unwrap_or(u32::MAX)
    })
}

/// The positions of a list; empty for a nonexistent cell or node.
fn list(data: &SceneData, cell_or_node: u32) -> Range<u32> {
    let at = cell_or_node as usize;
    if data.features.grid {
        match (data.grid_cells.get(at), data.grid_cells.get(at + 1)) {
            (Some(&first), Some(&end)) => first..end,
            _ => 0..0,
        }
    } else if data.features.irregular {
        let (first, count) = data.irregular_cells.get(at).map_or((0, 0), |_| data.list(cell_or_node));
        if count == 0 { 0..0 } else { first..first.saturating_add(count) }
    } else if data.features.bvh {
        data.bvh_nodes.get(at).map_or(0..0, |node| node.first..node.first.saturating_add(node.count()))
    } else {
        0..data.info.triangles
    }
}

/// The vertices of a triangle; `None` for a nonexistent one.
pub fn corners(data: &SceneData, triangle: u32) -> Option<[DVec3; 3]> {
    let first = (triangle as usize).checked_mul(9)?;
    let v = data.vertices.get(first..first.checked_add(9)?)?;
    Some([0, 3, 6].map(|c| to_f64([v[c], v[c + 1], v[c + 2]])))
}

fn nearest_hit(data: &SceneData, ray: &RayState) -> Option<NearestHit> {
    let (triangle, t) = (ray.triangle?, f64::from(ray.t?));
    let point = to_f64(ray.origin) + to_f64(ray.direction) * t;
    let barycentric = ray.barycentric.unwrap_or_default().map(f64::from);
    Some(NearestHit { triangle, t, point, barycentric, corners: corners(data, triangle)? })
}

/// Whether rays are traced through the cells of a grid that has any.
pub(crate) fn has_cells(data: &SceneData) -> bool {
    (data.features.grid || data.features.irregular) && data.grid.cells.iter().all(|&n| n > 0)
}

/// The coordinates of a cell: of the virtual cell at its lower corner, in an irregular grid.
pub(crate) fn coordinates(data: &SceneData, cell: u32) -> [i32; 3] {
    if data.features.irregular {
        return data.irregular_cells.get(cell as usize).map_or([0; 3], |cell| cell.corners()[0]);
    }
    data.grid.cell_of_index(cell)
}

pub(crate) fn to_f64(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn finite(t: f32) -> Option<f64> {
    (t < INF).then_some(f64::from(t))
}

/// Whether two rows are of the same ray: a pixel may have others, to lights or for other samples.
fn is_same_ray(a: &TraceRow, b: &TraceRow) -> bool {
    let bits = |ray: &RayState| [ray.origin, ray.direction].map(|v| v.map(f32::to_bits));
    bits(&a.after) == bits(&b.after)
}

/// Where the pass of a row took the ray.
fn path_of(row: &TraceRow) -> Path {
    PROGRAM.kernel(row.kernel).map_or(Path::Stays, |kernel| kernel.info().path)
}

#[cfg(test)]
pub(crate) mod tests;
