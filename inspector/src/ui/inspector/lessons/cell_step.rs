//! A step of the ray from a cell to its neighbour: what Amanatides and Woo's loop compares, changes and keeps.

use raystep_kernels::export::trace::{RayState, Trace, TraceGrid, TraceRow};
use raystep_kernels::scene_data::SceneData;

use crate::lesson::{Fact, Value};
use crate::walk::{AXES, row_after_passes};

/// A step, and the ray before and after it.
pub(super) struct CellStep<'a> {
    pub(super) before: &'a RayState,
    pub(super) after: &'a RayState,
    pub(super) from: [i32; 3],
    pub(super) to: [i32; 3],
    pub(super) axis: usize,
    /// Whether the current row made it.
    pub(super) is_made: bool,
    grid: TraceGrid,
    data: &'a SceneData,
}

/// The axis of a row that makes a step.
fn axis_of(row: &TraceRow) -> Option<usize> {
    let (from, to) = (row.cell_before?, row.cell_after?);
    let moved: Vec<usize> = (0..3).filter(|&axis| from[axis] != to[axis]).collect();
    match moved[..] {
        [axis] if from[axis].abs_diff(to[axis]) == 1 => Some(axis),
        _ => None,
    }
}

/// The rows of the steps among those after `row`, by their indices.
pub(super) fn steps_after(history: &Trace, row: usize) -> impl Iterator<Item = usize> {
    (row.saturating_add(1)..history.rows.len()).filter(|&row| axis_of(&history.rows[row]).is_some())
}

impl<'a> CellStep<'a> {
    /// The step that the current row made; otherwise the next one.
    pub(super) fn of(history: &'a Trace, data: &'a SceneData, place: usize) -> Result<Self, String> {
        if history.rows.iter().any(|row| row.after.control.is_some()) {
            return Err("this traversal has no tMax".into());
        }
        let current = row_after_passes(history, place);
        let is_step = |row: &usize| history.rows.get(*row).and_then(axis_of).is_some();
        let made = current.filter(is_step);
        let here = made.or_else(|| steps_after(history, current.unwrap_or(0)).next());
        let found = here.and_then(|row| {
            let (before, row) = (&history.rows.get(row.checked_sub(1)?)?.after, history.rows.get(row)?);
            let (from, to, axis) = (row.cell_before?, row.cell_after?, axis_of(row)?);
            Some(Self { before, after: &row.after, from, to, axis, is_made: made.is_some(), grid: history.grid?, data })
        });
        found.ok_or_else(|| "no step from cell to cell follows".into())
    }

    /// The t between two planes of an axis; `None` if the ray is parallel to them.
    pub(super) fn t_delta(&self, axis: usize) -> Option<f32> {
        self.grid.t_delta(self.before.direction)[axis]
    }

    /// The plane that it crosses, from the grid's corner.
    fn plane(&self) -> f32 {
        self.grid.width[self.axis] * self.from[self.axis].max(self.to[self.axis]) as f32
    }

    /// The axes whose tMax it changes.
    fn changed(&self) -> String {
        let is_changed = |axis: &usize| self.before.tmax[*axis] != self.after.tmax[*axis];
        let axes: Vec<&str> = (0..3).filter(is_changed).map(|axis| AXES[axis]).collect();
        if axes.is_empty() { "none".into() } else { axes.join(", ") }
    }

    /// A value of it.
    pub(super) fn fact(&self, fact: Fact) -> Result<Value, String> {
        let axis = self.axis;
        let single = |t: Option<f32>, why: &str| t.map(Value::single).ok_or_else(|| why.to_owned());
        let tmax = |t: [Option<f32>; 3], axis: usize| single(t[axis], "the ray never leaves the cell along this axis");
        let t_delta = |axis| single(self.t_delta(axis), "the ray is parallel to the planes of this axis");
        let cell = |[x, y, z]: [i32; 3]| Value::text(format!("{x},{y},{z}"));
        Ok(match fact {
            Fact::StepFrom => cell(self.from),
            Fact::StepTo => cell(self.to),
            Fact::StepAxis => Value::text(AXES[axis]),
            Fact::StepSign => Value::text(if self.to[axis] > self.from[axis] { "+1" } else { "-1" }),
            Fact::StepTMax => return tmax(self.before.tmax, axis),
            Fact::StepTMaxX => return tmax(self.before.tmax, 0),
            Fact::StepTMaxY => return tmax(self.before.tmax, 1),
            Fact::StepTMaxZ => return tmax(self.before.tmax, 2),
            Fact::StepNew => return tmax(self.after.tmax, axis),
            Fact::StepSum => {
                let sum = self.before.tmax[axis].zip(self.t_delta(axis)).map(|(t, by)| t + by);
                return single(sum, "the ray is parallel to the planes of this axis");
            }
            Fact::StepChanged => Value::text(self.changed()),
            Fact::StepTDelta => return t_delta(axis),
            Fact::StepTDeltaX => return t_delta(0),
            Fact::StepTDeltaY => return t_delta(1),
            Fact::StepTDeltaZ => return t_delta(2),
            Fact::StepWidth => Value::single(self.grid.width[axis]),
            Fact::StepPlane => Value::single(self.plane()),
            Fact::StepOrigin => Value::single(self.before.origin[axis] - self.grid.corner[axis]),
            Fact::StepDirection => Value::single(self.before.direction[axis]),
            _ => {
                let cell = self.data.grid.cell_index(self.to);
                Value::count(crate::walk::listed(self.data, cell).count() as u64)
            }
        })
    }
}
