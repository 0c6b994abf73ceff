//! The values of the run that a text can show.

use crate::walk::AXES;
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::numbers::real::Vec3;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::triangle::{Shear, hit_triangle};

use super::candidates::Candidates;
use super::cell_step::CellStep;
use super::light::Light;
use super::measured::{Measured, launched, misses};
use crate::lesson::{Clock, Fact, Field, Name, Value, Wrong};
use crate::session::Model;
use crate::session::request::Opened;
use crate::walk::{Entry, WalkGeometry, row_after_passes};

/// Where values come from.
pub(super) struct Facts<'a> {
    pub(super) model: &'a Model,
    pub(super) measured: &'a [Measured],
    pub(super) candidates: Option<&'a Candidates>,
}

/// A hit that does not count where it was found.
struct Beyond {
    axis: usize,
    /// The hit's coordinate and the plane's, or t and the exit.
    values: [f32; 2],
    /// The size of what was rounded: the hit's largest coordinate, or t.
    size: f32,
}

impl Facts<'_> {
    /// A value; an error says why there is none.
    pub(super) fn value(&self, name: &Name) -> Result<Value, Wrong> {
        let found = match name {
            Name::Fact(fact) => self.fact(*fact),
            Name::Measured(of, field) => self.field(of, *field),
        };
        found.map_err(|why| Wrong::Unavailable { name: name.to_string(), why })
    }

    fn fact(&self, fact: Fact) -> Result<Value, String> {
        let text = fact.name();
        match text.split_once('.').map_or("", |(of, _)| of) {
            "ray" => self.of_ray(fact),
            "row" => self.of_row(fact),
            "step" => CellStep::of(self.history()?, &self.opened()?.data, self.model.place)?.fact(fact),
            "light" => Light::of(self.history()?, self.opened()?)?.fact(fact),
            "vertex" => Light::of(self.history()?, self.opened()?)?.of_vertex(fact, self.row()?.0),
            "tie" => self.candidates.ok_or("the candidates were not found")?.fact(fact),
            _ => self.of_run(fact),
        }
    }

    fn opened(&self) -> Result<&Opened, String> {
        self.model.opened.as_ref().ok_or_else(|| "no scene is open".into())
    }

    fn of_run(&self, fact: Fact) -> Result<Value, String> {
        let (opened, model) = (self.opened()?, self.model);
        let last = || model.last_pass().ok_or("no pass has run");
        Ok(match fact {
            Fact::Scene => Value::text(&opened.scene.name),
            Fact::Triangles => Value::count(u64::from(opened.data.info.triangles)),
            Fact::Device => Value::text(&opened.device),
            Fact::Rays => Value::count(opened.plan.rays),
            Fact::Passes if model.is_complete => Value::count(model.passes.len() as u64),
            Fact::Passes => return Err("the run was not completed".into()),
            Fact::Pass => Value::count(last()?.index as u64),
            Fact::Kernel => Value::text(last()?.kernel.name()),
            Fact::Useful => Value::count(u64::from(last()?.rays_in)),
            Fact::Launched => Value::count(launched(&opened.plan, last()?)),
            Fact::Misses if !model.is_complete => return Err("the run was not completed".into()),
            Fact::Misses => {
                Value::count(misses(&opened.plan, &model.passes).ok_or("it is not known with these options")?)
            }
            _ if opened.data.features.grid => {
                let [x, y, z] = opened.data.grid.cells;
                Value::text(format!("{x} × {y} × {z}"))
            }
            _ => return Err("the run has no grid".into()),
        })
    }

    fn history(&self) -> Result<&Trace, String> {
        self.model.history.as_deref().ok_or_else(|| "no ray is selected".into())
    }

    fn of_ray(&self, fact: Fact) -> Result<Value, String> {
        let (history, data) = (self.history()?, &self.opened()?.data);
        let last = &history.rows.last().ok_or("no pass works on the ray")?.after;
        if let Fact::RayTriangle | Fact::RayT = fact {
            let (triangle, t) = last.triangle.zip(last.t).ok_or("the ray hits nothing")?;
            return Ok(if fact == Fact::RayT { Value::single(t) } else { Value::count(triangle.into()) });
        }
        let walk = WalkGeometry::new(history, data, usize::MAX);
        let leaps = || walk.cells.iter().filter_map(|cell| leapt(cell.entry));
        Ok(match fact {
            Fact::RayPixel => {
                let [x, y] = history.pixel;
                Value::text(format!("{x},{y}"))
            }
            Fact::RayPasses => Value::count(history.rows.len() as u64),
            Fact::RayCells => Value::count((walk.cells.len() + walk.nodes.len()) as u64),
            Fact::RayLeaps => Value::count(leaps().count() as u64),
            Fact::RayLeapt => Value::count(leaps().sum()),
            Fact::RayTests => Value::count(walk.tested.len() as u64),
            _ => {
                let is_again = |(i, test): (usize, &crate::walk::TestedTriangle)| {
                    walk.tested[..i].iter().any(|before| before.triangle == test.triangle)
                };
                Value::count(walk.tested.iter().enumerate().filter(|&both| is_again(both)).count() as u64)
            }
        })
    }

    /// The current row of the ray's history, and its index.
    fn row(&self) -> Result<(usize, &TraceRow), String> {
        let history = self.history()?;
        let index = row_after_passes(history, self.model.place);
        let found = index.and_then(|index| Some((index, history.rows.get(index)?)));
        found.ok_or_else(|| "no pass has worked on the ray yet".into())
    }

    fn of_row(&self, fact: Fact) -> Result<Value, String> {
        let (history, data, (index, row)) = (self.history()?, &self.opened()?.data, self.row()?);
        let tested = || row.tested.ok_or("this pass tests no triangle");
        Ok(match fact {
            Fact::RowPass => Value::text(row.number()),
            Fact::RowKernel => Value::text(row.kernel),
            Fact::RowWhy => Value::text(&row.why),
            Fact::RowTriangle => Value::count(tested()?.into()),
            Fact::RowCell => {
                let [x, y, z] = row.cell_before.ok_or("this pass works in no cell")?;
                Value::text(format!("{x},{y},{z}"))
            }
            Fact::RowListed => {
                let [x, y, z] = row.cell_before.ok_or("this pass works in no cell")?;
                let cell = data.grid.cell_index([x, y, z]);
                Value::count(crate::walk::listed(data, cell).count() as u64)
            }
            Fact::RowT => Value::single(self.t_of(row, tested()?)?),
            Fact::RowExit => Value::single(exit_of(history, index).ok_or("the ray never leaves this cell")?.1),
            Fact::RowLeapt => {
                let walk = WalkGeometry::new(history, data, index);
                let here = walk.cells.last().filter(|cell| cell.row == index);
                Value::count(here.and_then(|cell| leapt(cell.entry)).ok_or("this pass leaps over no cell")?)
            }
            Fact::RowAxis => Value::text(AXES[self.beyond()?.axis]),
            Fact::RowHit => Value::single(self.beyond()?.values[0]),
            Fact::RowPlane => Value::single(self.beyond()?.values[1]),
            Fact::RowBeyond => {
                let [hit, plane] = self.beyond()?.values.map(f64::from);
                Value::small((hit - plane).abs())
            }
            _ => {
                let Beyond { values: [hit, plane], size, .. } = self.beyond()?;
                let place = f64::from(size.next_up()) - f64::from(size);
                Value::count(((f64::from(hit) - f64::from(plane)).abs() / place).round() as u64)
            }
        })
    }

    /// t of the hit of a triangle that a row tests, in f32.
    fn t_of(&self, row: &TraceRow, triangle: u32) -> Result<f32, String> {
        if let Some(t) = row.after.t.filter(|_| row.after.triangle == Some(triangle)) {
            return Ok(t);
        }
        let data: &SceneData = &self.opened()?.data;
        let [o, d] = [row.after.origin, row.after.direction].map(Vec3::<f32>::from_f32);
        let found = hit_triangle::<f32>(data.features.triangle_rules(), o, d, &Shear::of(d), data.corners(triangle));
        if found.is_hit { Ok(found.t) } else { Err("the ray misses the triangle".into()) }
    }

    /// The hit of the current row that does not count in its cell.
    fn beyond(&self) -> Result<Beyond, String> {
        const NOT: &str = "this pass finds no hit beyond its cell";
        let (history, data, (index, row)) = (self.history()?, &self.opened()?.data, self.row()?);
        let (Some(triangle), Some(cell)) = (row.tested, row.cell_before) else { return Err(NOT.into()) };
        let t = self.t_of(row, triangle).map_err(|_| NOT)?;
        if !data.features.in_cell {
            let (axis, exit) = exit_of(history, index).ok_or(NOT)?;
            return if t > exit { Ok(Beyond { axis, values: [t, exit], size: t }) } else { Err(NOT.into()) };
        }
        // As the kernel does: the point, rounded, against the planes of the cell, rounded.
        let [o, d] = [row.after.origin, row.after.direction].map(Vec3::<f32>::from_f32);
        let point = (o + d * t).to_array();
        let low = data.grid.cell_plane::<f32>(cell);
        let high = (low + Vec3::from_f32(data.grid.width)).to_array();
        let low = low.to_array();
        let size = point.iter().fold(0.0, |most: f32, c| most.max(c.abs()));
        let outside = (0..3).flat_map(|axis| {
            let below = (point[axis] < low[axis]).then_some(low[axis]);
            let above = (point[axis] > high[axis]).then_some(high[axis]);
            below.or(above).map(|plane| Beyond { axis, values: [point[axis], plane], size })
        });
        let by = |beyond: &Beyond| (f64::from(beyond.values[0]) - f64::from(beyond.values[1])).abs();
        outside.max_by(|a, b| by(a).total_cmp(&by(b))).ok_or_else(|| NOT.into())
    }

    fn field(&self, of: &str, field: Field) -> Result<Value, String> {
        let measured = self.measured.iter().find(|measured| measured.name == of).ok_or("it was not measured")?;
        Ok(match field {
            Field::Passes => Value::count(measured.passes as u64),
            Field::Launched => Value::count(measured.launched),
            Field::Useful => Value::count(measured.useful),
            Field::Draws => Value::count(measured.drawn.ok_or(NOT_DRAWN)?.draws),
            Field::Copied => Value::bytes(measured.drawn.ok_or(NOT_DRAWN)?.copied),
            Field::Share => Value::share(measured.share()),
            Field::Misses => Value::count(measured.misses.ok_or("it is not known with these options")?),
            Field::Time => {
                let (ns, clock) = measured.time().ok_or("there is no clock")?;
                Value::time(ns, clock)
            }
            Field::DeviceTime => match (measured.device_ns, &measured.why_no_times) {
                (Some(ns), None) => Value::time(ns, Clock::Device),
                (_, Some(why)) => {
                    return Err(format!(
                        "the device's clock is not valid: {why}; NAME.time says which clock it is from"
                    ));
                }
                (None, None) => return Err("the passes were not timed".into()),
            },
        })
    }
}

/// Why a run has no draws.
const NOT_DRAWN: &str = "its kernels are compute shaders";

/// The axis and the t at which a ray leaves the cell that a row worked in.
fn exit_of(history: &Trace, index: usize) -> Option<(usize, f32)> {
    let row = history.rows.get(index)?;
    // The first pass that knows a cell has found its tMax itself.
    let before =
        index.checked_sub(1).and_then(|i| history.rows.get(i)).filter(|_| row.cell_before.is_some()).unwrap_or(row);
    let known = before.after.tmax.iter().enumerate().filter_map(|(axis, t)| Some((axis, (*t)?)));
    known.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The cells that a leap passes over: it crosses one face for each cell along each axis, and visits only the last one.
fn leapt(entry: Entry) -> Option<u64> {
    match entry {
        Entry::Leap { cells } => Some(cells.iter().map(|n| u64::from(n.unsigned_abs())).sum::<u64>().saturating_sub(1)),
        _ => None,
    }
}
