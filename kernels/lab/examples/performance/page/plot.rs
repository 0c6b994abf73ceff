//! Log-log plots as SVG files.

use std::path::Path;

use raystep_lab::plots::{self, Axis, Dash, Draw as _, Format, Mark, Plot, Scale, Stroke};

use super::text;

/// A named line.
pub(super) struct Series {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
    /// Index into [`COLORS`].
    pub(super) color: usize,
    pub(super) is_dashed: bool,
}

/// Labels of the axes.
pub(super) struct Axes {
    pub(super) title: String,
    pub(super) x: &'static str,
    pub(super) y: &'static str,
    /// Formats y values; x values are counts.
    pub(super) y_text: fn(f64) -> String,
}

/// Indices into the plots' palette: blue, vermilion, black, green, purple, light blue, olive.
const COLORS: [usize; 7] = [0, 1, 6, 2, 3, 4, 5];

/// Writes a plot, unless there is nothing to show.
pub(super) fn write(path: &Path, axes: &Axes, series: &[Series]) -> Result<(), String> {
    let points = || series.iter().flat_map(|s| &s.points).filter(|p| p.0 > 0.0 && p.1 > 0.0);
    if points().count() < 2 {
        return Ok(());
    }
    let drawn = |s: &Series| plots::Series {
        name: s.name.clone(),
        points: s.points.clone(),
        whiskers: Vec::new(),
        color: COLORS[s.color % COLORS.len()],
        mark: Mark::Own,
        stroke: Stroke::Line(if s.is_dashed { Dash::Dashed } else { Dash::Solid }),
    };
    let plot = Plot {
        title: axes.title.clone(),
        x: Axis { text: text::count, ..Axis::new(axes.x, Scale::Log) },
        y: Axis { text: axes.y_text, ..Axis::new(axes.y, Scale::Log) },
        series: series.iter().map(drawn).collect(),
        places: Vec::new(),
    };
    let Some(picture) = plot.picture(Format::TwoColumns) else { return Ok(()) };
    std::fs::write(path, picture.svg()).map_err(|e| format!("{}: {e}", path.display()))
}
