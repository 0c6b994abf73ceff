//! Small plots, one above the other, over a common horizontal axis.

use plotters::element::{PathElement, Rectangle};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{BLACK, Color as _};

use super::axis::Ranged;
use super::draw::{Drawn, GRID, PALETTE, dashes, drawn, mark, stroke, text_at};
use super::picture::Area;
use super::{Axis, Series};
use crate::Error;

const WIDTH: u32 = 440;
const LEFT: i32 = 66;
const RIGHT: i32 = 428;
/// Of the first row of names.
const TOP: i32 = 36;
/// Above each panel, for its label.
const GAP: i32 = 24;
/// Pixels between two labels of a vertical axis.
const LINE: i32 = 15;
/// Width of a character of a label, about.
const CHARACTER: i32 = 8;

/// Plots over one axis.
#[derive(Clone, Debug)]
pub struct Panels {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// From top to bottom.
    pub panels: Vec<Panel>,
    /// Named positions along x, drawn as vertical lines through all panels.
    pub places: Vec<(f64, String)>,
}

/// One of them.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Vertical axis.
    pub y: Axis,
    /// Height in pixels.
    pub height: u32,
    /// In drawing order. Names of all panels' series are shown once, above the first.
    pub series: Vec<Series>,
}

impl Panels {
    /// As an SVG element; `None` if there is nothing to show.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<Option<String>, Error> {
        let all = || self.panels.iter().flat_map(|p| p.series.iter().flat_map(|s| s.points.iter().map(|&p| p.0)));
        if all().filter(|&x| self.x.scale.has(x)).count() == 0 {
            return Ok(None);
        }
        let x = self.x.over(all().chain(self.places.iter().map(|p| p.0)));
        let names = self.names();
        let first = TOP + names.last().map_or(0, |name| name.1.1 - TOP) + 8 + GAP;
        let panels: i32 = self.panels.iter().map(|p| p.height as i32 + GAP).sum();
        let bottom = first + panels - GAP;
        drawn((WIDTH, (bottom + 46) as u32), |area| {
            text_at(area, &self.title, (8, 14), 15, (HPos::Left, VPos::Center))?;
            for (s, (x, y)) in names {
                let color = PALETTE[s.color % PALETTE.len()];
                stroke(area, s.stroke, &[(x, y), (x + 22, y)], color)?;
                mark(area, s.mark, (x + 11, y), color)?;
                text_at(area, &s.name, (x + 28, y), 12, (HPos::Left, VPos::Center))?;
            }
            let mut top = first;
            for panel in &self.panels {
                panel.draw(area, top, &x)?;
                top += panel.height as i32 + GAP;
            }
            let mut free = i32::MIN;
            for (value, text) in x.ticks() {
                let (at, half) = (across(&x, value), CHARACTER * text.chars().count() as i32 / 2);
                if at - half > free {
                    text_at(area, &text, (at, bottom + 6), 12, (HPos::Center, VPos::Top))?;
                    free = at + half;
                }
            }
            for (line, (value, name)) in (0..).zip(&self.places) {
                let at = across(&x, *value);
                dashes(area, &[(at, first), (at, bottom)], BLACK.stroke_width(1))?;
                // Beside the line, on the side with more space.
                let (x, side) = if at > (LEFT + RIGHT) / 2 { (at - 4, HPos::Right) } else { (at + 4, HPos::Left) };
                text_at(area, name, (x, first + 4 + LINE * line), 12, (side, VPos::Top))?;
            }
            text_at(area, &self.x.label, ((LEFT + RIGHT) / 2, bottom + 26), 13, (HPos::Center, VPos::Top))
        })
        .map(Some)
    }

    /// Series with different names, and where their names begin: rows above the panels.
    fn names(&self) -> Vec<(&Series, (i32, i32))> {
        let mut named: Vec<(&Series, (i32, i32))> = Vec::new();
        let (mut x, mut y) = (8, TOP);
        for s in self.panels.iter().flat_map(|p| &p.series).filter(|s| !s.name.is_empty()) {
            if named.iter().any(|(n, _)| (&n.name, n.color) == (&s.name, s.color)) {
                continue;
            }
            let width = 36 + 7 * s.name.chars().count() as i32;
            if x + width > WIDTH as i32 && x > 8 {
                (x, y) = (8, y + LINE + 2);
            }
            named.push((s, (x, y)));
            x += width + 8;
        }
        named
    }
}

fn across(x: &Ranged, value: f64) -> i32 {
    LEFT + (f64::from(RIGHT - LEFT) * x.part(value)).round() as i32
}

impl Panel {
    fn draw(&self, area: &Area<'_>, top: i32, x: &Ranged) -> Drawn {
        let bottom = top + self.height as i32;
        let points = self.series.iter().flat_map(|s| s.points.iter().map(|p| p.1));
        let ends = self.series.iter().flat_map(|s| &s.whiskers).flat_map(|w| [w.0, w.1]);
        let y = self.y.over(points.chain(ends));
        let up = |value: f64| bottom - (f64::from(bottom - top) * y.part(value)).round() as i32;
        for (value, _) in x.ticks() {
            area.draw(&PathElement::new([(across(x, value), top), (across(x, value), bottom)], GRID))?;
        }
        let mut free = i32::MAX;
        for (value, text) in y.ticks() {
            let at = up(value);
            area.draw(&PathElement::new([(LEFT, at), (RIGHT, at)], GRID))?;
            if at + LINE <= free || free == i32::MAX {
                text_at(area, &text, (LEFT - 5, at), 12, (HPos::Right, VPos::Center))?;
                free = at;
            }
        }
        area.draw(&Rectangle::new([(LEFT, top), (RIGHT, bottom)], BLACK.stroke_width(1)))?;
        for s in &self.series {
            let color = PALETTE[s.color % PALETTE.len()];
            let is_shown = |&(px, py): &(f64, f64)| self.y.scale.has(py) && px.is_finite();
            for (&(px, _), &(low, high)) in s.points.iter().zip(&s.whiskers).filter(|(p, _)| is_shown(p)) {
                let at = across(x, px);
                area.draw(&PathElement::new([(at, up(low)), (at, up(high))], color.stroke_width(1)))?;
            }
            let at: Vec<_> = s.points.iter().filter(|p| is_shown(p)).map(|p| (across(x, p.0), up(p.1))).collect();
            stroke(area, s.stroke, &at, color)?;
            at.iter().try_for_each(|&p| mark(area, s.mark, p, color))?;
        }
        text_at(area, &self.y.label, (LEFT, top - 5), 12, (HPos::Left, VPos::Bottom))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::Scale;

    #[test]
    fn panels_share_their_axis_and_legend() {
        let series = |y: f64| Series::line("grid", 0, vec![(1.0, y), (100.0, 2.0 * y)]);
        let panel = |y: f64, scale| Panel { y: Axis::new("ns", scale), height: 80, series: vec![series(y)] };
        let panels = vec![panel(3.0, Scale::Log), panel(0.0, Scale::LogWithZero)];
        let x = Axis::new("a < b", Scale::Log);
        let plot = Panels { title: "t".into(), x, panels, places: vec![(10.0, "here".into())] };
        let svg = plot.svg().expect("no error").expect("a plot");
        // Two points in each, and one in the legend.
        assert_eq!((svg.matches("<circle").count(), svg.matches("grid\n").count()), (5, 1), "{svg}");
        assert!(svg.contains("a &lt; b") && svg.contains("here"));
        let nothing = Panels { panels: vec![Panel { series: Vec::new(), ..panel(1.0, Scale::Log) }], ..plot };
        assert!(nothing.svg().expect("no error").is_none());
    }
}
