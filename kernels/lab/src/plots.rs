//! Plots, as SVG or as [pictures](picture) for a window.
//!
//! We compute axes, ticks and the legend, and plotters draws them: its logarithmic axes have too many or too few labels
//! and cannot show 0, a frequent count of wrong rays. Everything uses a few colours that the page's style sheet
//! replaces in dark mode.

mod axis;
mod draw;
mod forest;
mod labels;
mod panels;
pub mod picture;
pub mod precision;

use plotters::element::{PathElement, Rectangle};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{BLACK, Color as _, RGBColor, WHITE};

pub use axis::{Axis, Scale};
use draw::{FRAME, GRID, LEGEND, PALETTE, SIZE, border, dashes, drawn, frame, legend, mark, stroke, text_at};
pub use forest::Forest;
pub use panels::{Panel, Panels};

use crate::Error;

/// How points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// No mark.
    None,
    /// Discs.
    Dot,
    /// Triangles.
    Triangle,
    /// Squares.
    Square,
}

/// Marks of a [precision] diagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A disc.
    Disc,
    /// A square.
    Square,
    /// A triangle that points up.
    Up,
    /// A triangle that points down.
    Down,
}

/// How points are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// No line.
    None,
    /// A solid line.
    Solid,
    /// A dashed line.
    Dashed,
    /// A step line: each value holds until the next.
    Steps,
}

/// A data series.
#[derive(Clone, Debug)]
pub struct Series {
    /// Label in the legend. Series with the same name share an entry; an empty name has none.
    pub name: String,
    /// x and y of each point.
    pub points: Vec<(f64, f64)>,
    /// Lower and upper end along y, one per point; or empty.
    pub whiskers: Vec<(f64, f64)>,
    /// Index into the palette.
    pub color: usize,
    /// How points are drawn.
    pub mark: Mark,
    /// How they are connected.
    pub stroke: Stroke,
}

impl Series {
    /// A line with a dot at each point.
    pub fn line(name: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        let name = name.into();
        Self { name, points, whiskers: Vec::new(), color, mark: Mark::Dot, stroke: Stroke::Solid }
    }

    /// A theoretical line: dashed, without dots.
    pub fn dashed(name: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::None, stroke: Stroke::Dashed, ..Self::line(name, color, points) }
    }
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// In drawing order.
    pub series: Vec<Series>,
    /// Named positions along x, drawn as vertical lines.
    pub places: Vec<(f64, String)>,
}

/// A segment of a bar: length, and index into the palette.
pub type Part = (f64, usize);

/// A bar chart; each bar has a name and consecutive segments.
#[derive(Clone, Debug)]
pub struct Bars {
    /// Heading.
    pub title: String,
    /// Label of the length axis.
    pub x: String,
    /// Names of the first colours of the palette.
    pub legend: Vec<String>,
    /// From top to bottom.
    pub bars: Vec<(String, Vec<Part>)>,
}

impl Plot {
    /// As an SVG element; `None` if there is nothing to show.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<Option<String>, Error> {
        let is_shown = |&(x, y): &(f64, f64)| self.x.scale.has(x) && self.y.scale.has(y);
        let shown = |s: &Series| s.points.iter().copied().filter(is_shown).collect::<Vec<_>>();
        let points: Vec<Vec<(f64, f64)>> = self.series.iter().map(shown).collect();
        let all = || points.iter().flatten();
        if all().count() == 0 {
            return Ok(None);
        }
        let ends = self.series.iter().flat_map(|s| &s.whiskers).flat_map(|w| [w.0, w.1]);
        let x = self.x.over(all().map(|p| p.0).chain(self.places.iter().map(|p| p.0)));
        let y = self.y.over(all().map(|p| p.1).chain(ends));
        drawn(SIZE, |area| {
            frame(area, &self.title, &self.x.label, &self.y.label)?;
            let place = |(px, py): (f64, f64)| {
                let across = f64::from(FRAME.right - FRAME.left) * x.part(px);
                let up = f64::from(FRAME.bottom - FRAME.top) * y.part(py);
                (FRAME.left + across.round() as i32, FRAME.bottom - up.round() as i32)
            };
            for (value, text) in x.ticks() {
                let at = FRAME.left + (f64::from(FRAME.right - FRAME.left) * x.part(value)).round() as i32;
                area.draw(&PathElement::new([(at, FRAME.top), (at, FRAME.bottom)], GRID))?;
                text_at(area, &text, (at, FRAME.bottom + 7), 13, (HPos::Center, VPos::Top))?;
            }
            for (value, text) in y.ticks() {
                let at = FRAME.bottom - (f64::from(FRAME.bottom - FRAME.top) * y.part(value)).round() as i32;
                area.draw(&PathElement::new([(FRAME.left, at), (FRAME.right, at)], GRID))?;
                text_at(area, &text, (FRAME.left - 7, at), 13, (HPos::Right, VPos::Center))?;
            }
            border(area)?;
            for (i, (value, name)) in self.places.iter().enumerate() {
                let (at, _) = place((*value, 0.0));
                dashes(area, &[(at, FRAME.top), (at, FRAME.bottom)], BLACK.stroke_width(1))?;
                // Beside the line, on the side with more space.
                let is_right = at > (FRAME.left + FRAME.right) / 2;
                let (x, side) = if is_right { (at - 5, HPos::Right) } else { (at + 5, HPos::Left) };
                // One below the other, as they may be close together.
                text_at(area, name, (x, FRAME.top + 5 + 15 * i as i32), 13, (side, VPos::Top))?;
            }
            for (s, points) in self.series.iter().zip(&points) {
                let color = PALETTE[s.color % PALETTE.len()];
                for (&(px, _), &(low, high)) in s.points.iter().zip(&s.whiskers).filter(|(p, _)| is_shown(p)) {
                    let (from, to) = (place((px, low)), place((px, high)));
                    area.draw(&PathElement::new([from, to], color.stroke_width(1)))?;
                    for end in [from, to] {
                        area.draw(&PathElement::new([(end.0 - 4, end.1), (end.0 + 4, end.1)], color.stroke_width(1)))?;
                    }
                }
                let at: Vec<(i32, i32)> = points.iter().map(|&p| place(p)).collect();
                stroke(area, s.stroke, &at, color)?;
                for &p in &at {
                    mark(area, s.mark, p, color)?;
                }
            }
            legend(area, &self.series)
        })
        .map(Some)
    }
}

impl Bars {
    /// As an SVG element; `None` if there is nothing to show.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<Option<String>, Error> {
        let length = |parts: &[Part]| parts.iter().map(|p| p.0).sum::<f64>();
        let longest = self.bars.iter().map(|b| length(&b.1)).fold(0.0, f64::max);
        if longest <= 0.0 || !longest.is_finite() {
            return Ok(None);
        }
        let axis = Axis::new(self.x.clone(), Scale::Linear);
        let x = axis.over([0.0, longest].into_iter());
        drawn(SIZE, |area| {
            frame(area, &self.title, &self.x, "")?;
            let at = |v: f64| FRAME.left + (f64::from(FRAME.right - FRAME.left) * x.part(v)).round() as i32;
            for (value, text) in x.ticks() {
                area.draw(&PathElement::new([(at(value), FRAME.top), (at(value), FRAME.bottom)], GRID))?;
                text_at(area, &text, (at(value), FRAME.bottom + 7), 13, (HPos::Center, VPos::Top))?;
            }
            let step = (FRAME.bottom - FRAME.top) / self.bars.len().max(1) as i32;
            for (i, (name, parts)) in self.bars.iter().enumerate() {
                let top = FRAME.top + step * i as i32;
                let (from, to) = (top + step / 5, top + step * 4 / 5);
                text_at(area, name, (FRAME.left - 7, (from + to) / 2), 13, (HPos::Right, VPos::Center))?;
                let mut begin = 0.0;
                for &(part, color) in parts {
                    let style = PALETTE[color % PALETTE.len()].filled();
                    area.draw(&Rectangle::new([(at(begin), from), (at(begin + part), to)], style))?;
                    begin += part;
                }
            }
            border(area)?;
            for (i, name) in self.legend.iter().enumerate() {
                let y = FRAME.top + 12 + 24 * i as i32;
                area.draw(&Rectangle::new([(LEGEND, y - 6), (LEGEND + 20, y + 6)], PALETTE[i].filled()))?;
                text_at(area, name, (LEGEND + 30, y), 14, (HPos::Left, VPos::Center))?;
            }
            Ok(())
        })
        .map(Some)
    }
}

/// Turns an SVG file into an element of an HTML page: no namespace, one image to screen readers.
#[must_use]
pub fn inline(svg: &str) -> String {
    svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", " role=\"img\"", 1)
}

/// Colours on a dark background: lighter ones of the same hue as those of the palette.
const DARK: [[u8; 3]; 7] = [
    [0x4a, 0xa8, 0xe0],
    [0xff, 0x8a, 0x3d],
    [0x2f, 0xc7, 0x9a],
    [0xe5, 0x9c, 0xc4],
    [0x8f, 0xd0, 0xf5],
    [0xd0, 0xb8, 0x4a],
    [0xdd, 0xdd, 0xdd],
];

/// What a colour of a plot stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// The background.
    Paper,
    /// Lines behind the data.
    Rule,
    /// Text, axes and frames.
    Text,
    /// Data: the colours on a light and on a dark background.
    Data([[u8; 3]; 2]),
}

impl Ink {
    /// What the colour of an [element](picture::Element) stands for.
    #[must_use]
    pub fn of(color: [u8; 3]) -> Self {
        let [red, green, blue] = color;
        match RGBColor(red, green, blue) {
            WHITE => Self::Paper,
            GRID => Self::Rule,
            BLACK => Self::Text,
            data => {
                let at = PALETTE.iter().position(|known| *known == data);
                Self::Data([color, at.map_or(color, |at| DARK[at])])
            }
        }
    }
}

/// The style sheet of a page with plots. Plots are drawn for light mode; in dark mode their colours are replaced, those
/// of lines by lighter ones of the same hue.
#[must_use]
pub fn style() -> String {
    let mut style = String::from(
        "figure svg{max-width:100%;height:auto}@media(prefers-color-scheme:dark){svg [fill=\"#FFFFFF\"]{fill:\
         var(--paper)}svg [stroke=\"#E6E6E6\"]{stroke:var(--rule)}",
    );
    for (light, [red, green, blue]) in PALETTE.iter().zip(DARK) {
        let light = format!("#{:02X}{:02X}{:02X}", light.0, light.1, light.2);
        let dark = format!("#{red:02x}{green:02x}{blue:02x}");
        style += &format!("svg [fill=\"{light}\"]{{fill:{dark}}}svg [stroke=\"{light}\"]{{stroke:{dark}}}");
    }
    style + "}"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>, scale: Scale) -> Plot {
        let axis = |label: &str| Axis::new(label, scale);
        let series = vec![Series::line("a & b", 0, points)];
        Plot { title: "t < 1".into(), x: axis("time, ms"), y: axis("rays"), series, places: Vec::new() }
    }

    #[test]
    fn what_cannot_be_shown_is_left_out_and_nothing_is_no_plot() {
        let none = [plot(vec![], Scale::Log), plot(vec![(0.0, 1.0), (f64::NAN, 2.0), (1.0, -1.0)], Scale::Log)];
        for plot in none {
            assert!(plot.svg().expect("no error").is_none());
        }
        let svg = plot(vec![(1.0, 2.0), (10.0, 0.0), (1e30, 3.0)], Scale::Log).svg().expect("no error");
        let svg = svg.expect("a plot");
        assert!(svg.starts_with("<svg") && svg.contains("a &amp; b") && svg.contains("t &lt; 1"), "{svg}");
        // Two points, and the legend's.
        assert_eq!(svg.matches("<circle").count(), 3);
        let empty = Bars { title: String::new(), x: String::new(), legend: Vec::new(), bars: Vec::new() };
        assert!(empty.svg().expect("no error").is_none());
    }

    #[test]
    fn zero_has_a_place_where_the_axis_is_one_of_counts() {
        let svg = plot(vec![(1.0, 0.0), (10.0, 300.0)], Scale::LogWithZero).svg().expect("no error").expect("a plot");
        assert_eq!(svg.matches("<circle").count(), 3);
    }
}
