//! The cells of a walk through the grid.

use glam::DVec3;
use raystep_kernels::export::trace::{RayState, TraceRow};
use raystep_kernels::numbers::real::Vec3;
use raystep_kernels::program::Path;
use raystep_kernels::programs::closest_hit::states;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::constants::INF;
use raystep_kernels::shared::grid_walk::{WalkRules, smallest_axis};
use raystep_kernels::shared::irregular_walk::VoxelWalk;

use super::{Aabb, WalkGeometry, coordinates, finite, list, path_of};

/// How a ray entered a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// The walk starts here.
    Start,
    /// Through the face shared with the previous cell.
    Face {
        /// The axis of the step.
        axis: usize,
        /// 1 or -1.
        step: i32,
    },
    /// Across cells that were not visited one by one: they are empty, or the pass took several steps.
    Leap {
        /// The number of cells, along each axis.
        cells: [i32; 3],
    },
    /// Across a face of the grid, where the paper's rules take the index of a cell in the next row for that of the next
    /// cell.
    Wrap,
}

/// A visited cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellVisit {
    /// The row that moved the ray here.
    pub row: usize,
    /// Cell coordinates.
    pub cell: [i32; 3],
    /// The cell's number, x fastest.
    pub index: u32,
    /// Its box.
    pub bounds: Aabb,
    /// How the ray entered.
    pub entry: Entry,
    /// t at which the ray enters.
    pub t_in: f64,
    /// t at which it leaves: the smallest tmax. Equal to `t_in` if it crosses no plane.
    pub t_out: f64,
    /// t at which the ray leaves the cell, per axis; `None` for an axis that it never crosses.
    pub tmax: [Option<f64>; 3],
    /// The axis with the smallest tmax.
    pub exit_axis: usize,
    /// Triangles in the cell's list.
    pub listed: u32,
    /// Whether the ray is here now, or ended its walk here.
    pub is_current: bool,
    /// Whether it is a cell of an irregular grid, which is named by its number.
    pub is_irregular: bool,
    /// Whether it is the space around an irregular grid, with the triangles that were set aside.
    pub is_outside: bool,
}

impl CellVisit {
    /// `cell 1,0,2`, or `cell 17` in an irregular grid, or `outside`.
    #[must_use]
    pub fn name(&self) -> String {
        match self.is_irregular {
            _ if self.is_outside => "outside".into(),
            true => format!("cell {}", self.index),
            false => format!("cell {}", self.cell.map(|c| c.to_string()).join(",")),
        }
    }
}

/// Where the ray crosses a plane between cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Index of the cell visit that it leaves.
    pub from: usize,
    /// The axis across which the plane lies.
    pub axis: usize,
    /// Its t: a tmax of that cell.
    pub t: f64,
    /// Its position.
    pub point: DVec3,
}

impl WalkGeometry {
    /// Processes a row that may move the ray to another cell, or out of the grid.
    pub(super) fn move_to_cell(&mut self, data: &SceneData, i: usize, row: &TraceRow, before: Option<&RayState>) {
        let path = path_of(row);
        let starts = path == Path::Enters;
        let steps = matches!(path, Path::NextCell | Path::Several);
        if !starts && !steps {
            return;
        }
        let after = &row.after;
        let moved = starts || before.is_none_or(|before| before.cell_index != after.cell_index);
        // A pass of several steps may end the walk in the current cell, or in another one.
        let left = path == Path::NextCell || moved || states::of_any_ray(after.tag) == states::BACKGROUND;
        if steps && left {
            self.leave_cell();
        }
        if moved && (steps || after.is_walking) {
            let visit = self.visit(data, i, after);
            self.cells.push(visit);
        }
    }

    fn leave_cell(&mut self) {
        let from = self.cells.len().wrapping_sub(1);
        let Some(cell) = self.cells.last_mut() else { return };
        cell.is_current = false;
        let (axis, t) = (cell.exit_axis, cell.t_out);
        if cell.tmax[axis].is_some() && !cell.is_outside {
            let point = self.point(t);
            self.crossings.push(Crossing { from, axis, t, point });
        }
    }

    fn visit(&self, data: &SceneData, row: usize, ray: &RayState) -> CellVisit {
        let grid = &data.grid;
        let index = ray.cell_index;
        let cell = coordinates(data, index);
        let is_outside = data.is_outside(index);
        let bounds = match is_outside {
            true => Aabb::of_vertices(&data.vertices),
            false => Aabb::of_cells(grid, cell, size_of(data, index)),
        };
        let tmax = self.tmax(data, cell, ray);
        let [x, y, _] = smallest_axis(Vec3::from(tmax.map(|t| t.unwrap_or(f64::from(INF)))));
        let exit_axis = if x {
            0
        } else if y {
            1
        } else {
            2
        };
        let wraps = !data.features.robust && !data.features.many_steps;
        let entry = self.cells.last().map_or(Entry::Start, |from| match entry(from.cell, cell) {
            _ if from.is_outside => Entry::Start,
            // Whatever its size, the next cell is behind the face by which the ray left.
            _ if data.features.irregular && !data.features.many_steps => {
                Entry::Face { axis: from.exit_axis, step: if self.direction[from.exit_axis] < 0.0 { -1 } else { 1 } }
            }
            Entry::Leap { .. } if wraps => Entry::Wrap,
            entry => entry,
        });
        let own = bounds.interval(self.origin, self.direction).map(|[enter, _]| enter);
        let t_in = match (entry, self.cells.last()) {
            (Entry::Face { .. }, Some(from)) => from.t_out,
            _ if is_outside => 0.0,
            (_, from) => own.or(from.map(|from| from.t_out)).unwrap_or(0.0),
        };
        let list = list(data, index);
        CellVisit {
            row,
            cell,
            index,
            bounds,
            entry,
            t_in,
            t_out: tmax[exit_axis].unwrap_or(t_in),
            tmax,
            exit_axis,
            listed: list.end.saturating_sub(list.start),
            is_current: true,
            is_irregular: data.features.irregular,
            is_outside,
        }
    }

    /// From the stream, or, if a run has none, computed from the cell as the kernel does.
    fn tmax(&self, data: &SceneData, cell: [i32; 3], ray: &RayState) -> [Option<f64>; 3] {
        if ray.tmax.iter().any(Option::is_some) {
            return ray.tmax.map(|t| t.map(f64::from));
        }
        let [origin, direction] = [ray.origin, ray.direction].map(Vec3::<f32>::from_f32);
        // A 3D-DDA computes no t: then as Amanatides and Woo do, from the planes of the cell.
        let rules = WalkRules { robust: true, ..data.features.walk_rules() };
        let grid_ray = data.grid.ray(rules, origin, direction);
        if data.features.irregular {
            let has_cell = (ray.cell_index as usize) < data.irregular_cells.len();
            let walk = VoxelWalk { voxel: [0; 3], cell: ray.cell_index, inside: true };
            let exits = || data.irregular().exit(&walk, &grid_ray);
            if has_cell { exits().to_array().map(finite) } else { [None; 3] }
        } else if data.features.keeps_no_tmax() || data.features.dda {
            data.grid.cell_exit(cell, &grid_ray).to_array().map(finite)
        } else {
            [None; 3]
        }
    }
}

/// The size of a cell in cells of the grid, or in virtual ones.
fn size_of(data: &SceneData, cell: u32) -> [i32; 3] {
    let cell = data.irregular_cells.get(cell as usize).filter(|_| data.features.irregular);
    cell.map_or([1; 3], |cell| {
        let [low, high] = cell.corners();
        [0, 1, 2].map(|axis| high[axis] - low[axis])
    })
}

fn entry(from: [i32; 3], to: [i32; 3]) -> Entry {
    let step = [0, 1, 2].map(|a| to[a].saturating_sub(from[a]));
    match step.map(i32::abs) {
        [1, 0, 0] => Entry::Face { axis: 0, step: step[0] },
        [0, 1, 0] => Entry::Face { axis: 1, step: step[1] },
        [0, 0, 1] => Entry::Face { axis: 2, step: step[2] },
        _ => Entry::Leap { cells: step },
    }
}
