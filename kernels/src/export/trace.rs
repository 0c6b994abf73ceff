//! The history of one ray as a table for people and as CSV.

use std::fmt::Write as _;

#[cfg(feature = "serde")]
use super::csv::known;
use crate::history::units::{Scale, Units, exact};
pub use crate::history::*;

impl Trace {
    /// A table for people: the ray and its grid, then one line per row.
    #[must_use]
    pub fn table(&self, units: Units) -> String {
        let scale = Scale::of(units, self);
        let decimals = scale.decimals(self);
        let mut out = self.head(&scale);
        let is_dda = self.rows.iter().any(|row| row.after.control.is_some());
        let per_axis = if is_dda { "control" } else { "tmax" };
        // Only with a BVH is there a previous node.
        let place = if self.rows.iter().any(|row| row.after.previous.is_some()) { "node" } else { "cell" };
        let header = ["pass", "kernel", "state", place, per_axis, "item", "t", "hit"];
        let rows: Vec<[String; 8]> = self.rows.iter().map(|row| cells(row, &scale, decimals)).collect();
        let width = |c: usize| rows.iter().map(|r| r[c].len()).chain([header[c].len()]).max().unwrap_or(0);
        let widths: Vec<usize> = (0..8).map(width).collect();
        let mut line = |cells: [&str; 8], why: &str| {
            for (cell, width) in cells.iter().zip(&widths) {
                let _ = write!(out, "{cell:<width$}  ");
            }
            let _ = writeln!(out, "{why}");
        };
        line(header, "why");
        for (row, cells) in self.rows.iter().zip(&rows) {
            line(cells.each_ref().map(String::as_str), &(scale.reason(&row.why) + &row.noted()));
        }
        let noun = self.element.map_or("ray", |element| element.noun());
        let _ = match self.passes {
            Some(passes) => {
                let waited = passes.saturating_sub(self.rows.len());
                writeln!(
                    out,
                    "\n{passes} passes. This {noun} waited in {waited} of them, whose numbers are missing here."
                )
            }
            None => writeln!(
                out,
                "\nOnly this ray was traced (use --all-rays for the total number of passes). Passes whose numbers are missing \
                 run kernels for which this ray is not ready."
            ),
        };
        let _ = writeln!(out, "{place}, {per_axis}, item, t and hit are those after the pass");
        let traced = self.scene_units_per_stream_unit;
        let _ = match units {
            Units::Scene => {
                writeln!(
                    out,
                    "lengths and t are in scene units; the streams' traced units are {traced} scene units each"
                )
            }
            Units::Traced => writeln!(
                out,
                "lengths are in traced units, of {traced} scene units each; multiply t by {} for t in scene units",
                self.t_scale
            ),
        };
        out
    }

    /// What the first rows are computed from.
    fn head(&self, scale: &Scale) -> String {
        let mut out = String::new();
        let mut line = |name: &str, what: String| out.push_str(&format!("{name:7} {what}\n"));
        let all = |numbers: [f64; 3]| numbers.map(exact).join(" ");
        let ray = self.rows.first().map(|row| row.after);
        // With several samples there are several rays.
        let ray = ray.filter(|ray| self.rows.iter().all(|row| row.after.direction == ray.direction));
        if let Some(element) = self.element {
            line("element", element.to_string());
        }
        if let Some(RayState { origin, direction, .. }) = ray {
            let origin = scale.point(origin).join(" ");
            line("ray", format!("origin {origin}, direction {}", all(direction.map(|d| scale.direction(d)))));
        }
        if let Some(grid) = self.grid {
            let [x, y, z] = grid.cells;
            let corner = [0, 1, 2].map(|axis| scale.coordinate(axis, grid.corner[axis]));
            let width = all(grid.width.map(|w| scale.length(w)));
            line("grid", format!("{x} x {y} x {z} cells from corner {}, each of size {width}", all(corner)));
            if let Some(ray) = ray {
                let t_delta = grid.t_delta(ray.direction).map(|t| t.map_or_else(|| "-".into(), |t| scale.exact_t(t)));
                line("tdelta", t_delta.join(" "));
            }
        }
        if !out.is_empty() {
            out.push('\n');
        }
        out
    }

    /// RFC 4180, raw numbers; missing values are empty. A column says in its name whether it is from before or after the
    /// pass, and whether it is in traced or in scene units; `tested_triangle` is the one that the pass tested. `why` quotes
    /// t in traced units.
    ///
    /// # Errors
    /// If `out` cannot be written.
    #[cfg(feature = "serde")]
    pub fn write_csv(&self, out: impl std::io::Write) -> Result<(), csv::Error> {
        let mut csv = super::csv::writer(out);
        csv.write_record([
            "pass",
            "kernel",
            "state_before",
            "state_after",
            "cell_after_x",
            "cell_after_y",
            "cell_after_z",
            "index_after",
            "tmax_after_x_traced",
            "tmax_after_y_traced",
            "tmax_after_z_traced",
            "control_after_x",
            "control_after_y",
            "control_after_z",
            "item_after",
            "t_after_traced",
            "t_after_scene",
            "u_after",
            "v_after",
            "triangle_after",
            "tested_triangle",
            "why",
        ])?;
        for row in &self.rows {
            let a = &row.after;
            let mut record = vec![known(row.pass), row.kernel.into(), row.state_before.into(), a.state.into()];
            record.extend((0..3).map(|i| known(row.cell_after.map(|c| c[i]))));
            record.push(known(row.index_after));
            record.extend(a.tmax.map(known));
            record.extend((0..3).map(|i| known(a.control.map(|c| c[i]))));
            record.extend([a.item.to_string(), known(a.t), known(a.t.map(|t| f64::from(t) * self.t_scale))]);
            record.extend((0..2).map(|i| known(a.barycentric.map(|b| b[i]))));
            record.extend([known(a.triangle), known(row.tested), row.why.clone() + &row.noted()]);
            csv.write_record(record)?;
        }
        csv.flush()?;
        Ok(())
    }
}

/// The cell or node that the ray is in after the pass.
fn place(row: &TraceRow) -> String {
    match (row.cell_after, row.index_after) {
        (Some([x, y, z]), _) => format!("{x},{y},{z}"),
        (None, Some(index)) => index.to_string(),
        (None, None) => "-".into(),
    }
}

/// The texts of a row but the reason.
fn cells(row: &TraceRow, scale: &Scale, decimals: [usize; 4]) -> [String; 8] {
    let a = &row.after;
    let numbers = scale.numbers(a);
    let short = |i: usize| numbers[i].map_or_else(|| "-".into(), |number| format!("{number:.0$}", decimals[i]));
    [
        row.number(),
        row.kernel.into(),
        if row.state_before == a.state { a.state.into() } else { format!("{} > {}", row.state_before, a.state) },
        place(row),
        format!("{} {} {}", short(0), short(1), short(2)),
        a.item.to_string(),
        short(3),
        a.triangle.map_or_else(|| "-".into(), |t| t.to_string()),
    ]
}

#[cfg(test)]
mod tests {
    use raystep_scenes::generate;

    use super::*;
    use crate::plan::Plan;
    use crate::{Accelerator, GridSize, Limits, Options, RaySource, ScheduleKind};

    /// The numbers in a line of a table that begins with this word.
    fn numbers(table: &str, word: &str) -> Vec<f64> {
        let line = table.lines().find(|line| line.starts_with(word)).unwrap_or_default();
        line.split([' ', ',']).filter_map(|word| word.parse().ok()).collect()
    }

    #[test]
    fn the_first_tmax_follows_from_the_ray_and_the_grid_above_the_rows_in_either_unit() {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let source = RaySource::Camera { camera, width: 512, height: 512 };
        let schedule = ScheduleKind::Second;
        let (accelerator, grid) = (Accelerator::Grid, GridSize::Cells([5; 3]));
        let options = Options { accelerator, grid, schedule, ..Options::new(source) };
        let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene");
        let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
        let life = run.follow::<f32>([360, 180]).expect("a ray");
        for (units, distance) in [(Units::Traced, 0.825), (Units::Scene, 3.3)] {
            let table = life.table(units);
            let (ray, grid) = (numbers(&table, "ray"), numbers(&table, "grid"));
            let (tdelta, setup) = (numbers(&table, "tdelta"), numbers(&table, "1 "));
            assert_eq!((ray[2], &grid[..3]), (distance, &[5.0; 3][..]), "{table}");
            for axis in 0..3 {
                let (origin, direction, corner, width) = (ray[axis], ray[3 + axis], grid[3 + axis], grid[6 + axis]);
                let cell = ((origin - corner) / width).floor() + f64::from(u8::from(direction > 0.0));
                let tmax = (corner + cell * width - origin) / direction;
                // After the pass's number and the cell.
                assert!((tmax - setup[4 + axis]).abs() < 1e-5 * distance, "{tmax}: {table}");
                assert!((width / direction.abs() - tdelta[axis]).abs() < 1e-6 * distance, "{table}");
            }
        }
    }
}
