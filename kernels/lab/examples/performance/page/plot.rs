//! Plots as SVG, both axes logarithmic, on white: read in a light and in a dark page.

use std::ops::Range;
use std::path::Path;

use plotters::prelude::*;

use super::text;

/// A line with a name.
pub(super) struct Series {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
    /// Index into the palette.
    pub(super) color: usize,
    pub(super) is_dashed: bool,
}

/// What the axes mean.
pub(super) struct Axes {
    pub(super) title: String,
    pub(super) x: &'static str,
    pub(super) y: &'static str,
    /// How values of y are written; those of x are counts.
    pub(super) y_text: fn(f64) -> String,
}

/// Okabe and Ito's colours, which people who see few colours can tell apart.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 0, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(150, 130, 20),
];

/// Writes a plot; none where there is nothing to show.
pub(super) fn write(path: &Path, axes: &Axes, series: &[Series]) -> Result<(), String> {
    let points = || series.iter().flat_map(|s| s.points.iter().copied()).filter(|p| p.0 > 0.0 && p.1 > 0.0);
    if points().count() < 2 {
        return Ok(());
    }
    draw(path, axes, series, range(points().map(|p| p.0), 1.1), range(points().map(|p| p.1), 1.4))
        .map_err(|e| format!("{}: {e}", path.display()))
}

fn range(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0), |(low, high), v| (f64::min(low, v), f64::max(high, v)));
    low / margin..high * margin
}

/// Labels at 1, 2, 5 of each decade; more would run into each other.
fn tick(value: f64, text: fn(f64) -> String) -> String {
    let leading = value / 10f64.powf(value.log10().floor());
    if [1.0, 2.0, 5.0, 10.0].iter().any(|l| (leading - l).abs() < 0.01) { text(value) } else { String::new() }
}

fn draw(
    path: &Path,
    axes: &Axes,
    series: &[Series],
    x: Range<f64>,
    y: Range<f64>,
) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::new(path, (860, 500)).into_drawing_area();
    area.fill(&WHITE)?;
    // The legend stands beside the lines, where it hides none.
    let (left, right) = area.split_horizontally(620);
    let mut chart = ChartBuilder::on(&left)
        .caption(&axes.title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(84)
        .build_cartesian_2d(x.log_scale(), y.log_scale())?;
    chart
        .configure_mesh()
        .x_desc(axes.x)
        .y_desc(axes.y)
        .x_label_formatter(&|v| tick(*v, text::count))
        .y_label_formatter(&|v| tick(*v, axes.y_text))
        .x_labels(24)
        .y_labels(40)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(238, 238, 238))
        .draw()?;
    for (i, s) in series.iter().enumerate() {
        let color = PALETTE[s.color % PALETTE.len()];
        let style = color.stroke_width(2);
        let points = s.points.iter().copied();
        if s.is_dashed {
            chart.draw_series(DashedLineSeries::new(points, 7, 4, style))?;
        } else {
            // Piece by piece: some viewers fill a longer line as if it were a shape.
            let pieces: Vec<_> = points.collect();
            chart.draw_series(pieces.windows(2).map(|piece| PathElement::new(piece, style)))?;
        }
        chart.draw_series(s.points.iter().map(|&p| Circle::new(p, 3, color.filled())))?;
        let at = 60 + 24 * i as i32;
        let parts: &[(i32, i32)] = if s.is_dashed { &[(0, 7), (11, 18), (22, 28)] } else { &[(0, 28)] };
        for &(from, to) in parts {
            right.draw(&PathElement::new([(from, at), (to, at)], style))?;
        }
        right.draw(&Text::new(s.name.clone(), (36, at - 7), ("sans-serif", 14)))?;
    }
    area.present()?;
    Ok(())
}
