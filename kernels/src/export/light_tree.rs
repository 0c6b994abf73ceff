//! A pixel's light tree as a table for people. As JSON, it is a value that serialises.

use std::fmt::Write as _;

use crate::history::Trace;
pub use crate::history::light_tree::*;
use crate::history::units::Units;

const ABOUT: &str = "Every ray ends in a line below the one that it left. r g b are linear: what arrives along the ray, or would if \
                     nothing\nwere in its way; and what the line adds to the pixel, with those below it.";

impl LightTree {
    /// One line per vertex, indented below the one that its ray left, and what all add up to.
    #[must_use]
    pub fn table(&self, life: &Trace, units: Units) -> String {
        let header = ["vertex", "passes", "point", "arrives r g b", "adds r g b"];
        let lines = self.lines(life, units);
        let cells = |line: &Line| {
            let name = "  ".repeat(line.level) + &line.name;
            [name, line.passes.clone(), line.place.clone(), line.arrives.clone(), line.adds.clone()]
        };
        let rows: Vec<[String; 5]> = lines.iter().map(cells).collect();
        let width = |c: usize| rows.iter().map(|row| row[c].chars().count()).chain([header[c].len()]).max();
        let widths = [0, 1, 2, 3, 4].map(|c| width(c).unwrap_or_default());
        let mut out = format!("light tree\n{ABOUT}\n\n");
        let mut line = |cells: [&str; 5], why: &str| {
            for (cell, width) in cells.iter().zip(widths) {
                let _ = write!(out, "{cell:<width$}  ");
            }
            let _ = writeln!(out, "{why}");
        };
        line(header, "why it ends");
        for (row, told) in rows.iter().zip(&lines) {
            line(row.each_ref().map(String::as_str), &told.why);
        }
        let sum = self.sum().map(|c| format!("{c:.6}")).join(" ");
        let _ = writeln!(out, "\nall lines add up to {sum}, the pixel's colour");
        out
    }
}
