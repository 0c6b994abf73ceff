//! The history of one ray as a table for people and as CSV.

use std::fmt::Write as _;

#[cfg(feature = "serde")]
use super::csv::known;
pub use crate::history::*;

impl Trace {
    /// A table for people: one line per row.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        let is_dda = self.rows.iter().any(|row| row.after.control.is_some());
        let per_axis = if is_dda { "control" } else { "tmax" };
        // Only with a BVH is there a previous node.
        let place = if self.rows.iter().any(|row| row.after.previous.is_some()) { "node" } else { "cell" };
        let header = ["pass", "kernel", "state", place, per_axis, "item", "t", "hit"];
        let rows: Vec<[String; 8]> = self.rows.iter().map(cells).collect();
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
            line(cells.each_ref().map(String::as_str), &row.why);
        }
        let _ = match self.passes {
            Some(passes) => {
                let waited = passes.saturating_sub(self.rows.len());
                writeln!(out, "\n{passes} passes. This ray waited in {waited} of them, whose numbers are missing here.")
            }
            None => writeln!(
                out,
                "\nOnly this ray was traced (use --all-rays for the total number of passes). Passes whose numbers are missing \
                 run kernels for which this ray is not ready."
            ),
        };
        let (unit, t) = (self.scene_units_per_stream_unit, self.t_scale);
        let _ = writeln!(out, "{place}, {per_axis}, item, t and hit are those after the pass");
        let _ = writeln!(
            out,
            "lengths are in traced units, of {unit} scene units each; multiply t by {t} for t in scene units"
        );
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
            record.extend([known(a.triangle), known(row.tested), row.why.clone()]);
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

fn cells(row: &TraceRow) -> [String; 8] {
    let a = &row.after;
    let short = |t: Option<f32>| t.map_or_else(|| "-".into(), |t| format!("{t:.5}"));
    let [x, y, z] = a.per_axis();
    [
        row.number(),
        row.kernel.into(),
        if row.state_before == a.state { a.state.into() } else { format!("{} > {}", row.state_before, a.state) },
        place(row),
        format!("{} {} {}", short(x), short(y), short(z)),
        a.item.to_string(),
        short(a.t),
        a.triangle.map_or_else(|| "-".into(), |t| t.to_string()),
    ]
}
