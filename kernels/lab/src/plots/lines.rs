//! Series of points over an axis, in one panel or in several, one above the other.

use super::axis::Ranged;
use super::draw::{above, across, below, beside, columns, left_of, points, up, upright};
use super::frame::Frame;
use super::legend::{Entry, entries, head, places};
use super::picture::{Picture, Point};
use super::{Axis, Draw, Format, Series};

/// A plot.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// From top to bottom.
    pub panels: Vec<Panel>,
    /// Named positions along x, drawn as vertical lines through all panels.
    pub places: Vec<(f64, String)>,
}

/// Series over a vertical axis.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Vertical axis.
    pub y: Axis,
    /// Height in units; `None` follows the width.
    pub height: Option<f64>,
    /// In drawing order. Names of all panels' series are shown once, above the first.
    pub series: Vec<Series>,
}

/// Width on a screen, and that of several panels.
pub(super) const WIDTH: f64 = 860.0;
const WIDTH_OF_PANELS: f64 = 440.0;
/// Right of a plot.
pub(super) const RIGHT: f64 = 12.0;

impl Plot {
    /// A plot of one panel.
    #[must_use]
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, series: Vec<Series>) -> Self {
        Self { title: title.into(), x, panels: vec![Panel { y, height: None, series }], places: Vec::new() }
    }
}

impl Draw for Plot {
    fn title(&self) -> &str {
        &self.title
    }

    fn picture(&self, format: Format) -> Option<Picture> {
        let all = || self.panels.iter().flat_map(|panel| panel.shown(&self.x)).map(|(&point, _)| point);
        all().next()?;
        let x = self.x.over(all().map(|p| p.0).chain(self.places.iter().map(|p| p.0)));
        let mut picture = Picture::new(format, if self.panels.len() > 1 { WIDTH_OF_PANELS } else { WIDTH });
        let (positions, named): (Vec<f64>, Vec<Entry>) = places(&self.places).unzip();
        let series = self.panels.iter().flat_map(|panel| &panel.series);
        let legend: Vec<Entry> = entries(series).into_iter().chain(named.iter().cloned()).collect();
        let mut top = head(&mut picture, &self.title, &legend);
        let ranges: Vec<Ranged> = self.panels.iter().map(|panel| panel.range(&self.x)).collect();
        let usual = (0.5 * picture.width()).clamp(190.0, 290.0);
        let heights = || self.panels.iter().map(|panel| panel.height.unwrap_or(usual));
        let rows: Vec<_> = ranges.iter().zip(heights()).map(|(y, height)| left_of(y, height)).collect();
        let left = rows.iter().map(|(_, left)| *left).fold(0.0, f64::max);
        let mut frame = Frame { left, right: picture.width() - RIGHT, top, bottom: top };
        let columns = columns(&picture, frame, &x);
        for (((panel, y), (rows, _)), height) in self.panels.iter().zip(&ranges).zip(&rows).zip(heights()) {
            frame.top = above(&mut picture, &panel.y.label, top);
            frame.bottom = frame.top + height;
            upright(&mut picture, frame, &x, &columns);
            beside(&mut picture, frame, y, rows);
            for (value, entry) in positions.iter().zip(&named) {
                entry.draw_along(&mut picture, across(frame, &x, *value), [frame.top, frame.bottom]);
            }
            panel.draw(&mut picture, frame, &self.x, [&x, y]);
            picture.border(frame);
            top = frame.bottom + 4.0;
        }
        picture.size.1 = below(&mut picture, frame, &x, &columns, &self.x.label);
        Some(picture)
    }
}

impl Panel {
    /// The points of all series that both scales have, each with its interval, if there is one.
    fn shown<'a>(&'a self, x: &'a Axis) -> impl Iterator<Item = (&'a Point, Option<&'a Point>)> {
        self.series.iter().flat_map(|s| self.shown_of(x, s))
    }

    fn shown_of<'a>(&'a self, x: &'a Axis, s: &'a Series) -> impl Iterator<Item = (&'a Point, Option<&'a Point>)> {
        let all = s.points.iter().enumerate().map(|(i, point)| (point, s.whiskers.get(i)));
        all.filter(|(point, _)| x.scale.has(point.0) && self.y.scale.has(point.1))
    }

    fn range(&self, x: &Axis) -> Ranged {
        let ends = self.series.iter().flat_map(|s| &s.whiskers).flat_map(|w| [w.0, w.1]);
        self.y.over(self.shown(x).map(|(point, _)| point.1).chain(ends))
    }

    fn draw(&self, picture: &mut Picture, frame: Frame, x: &Axis, [over_x, over_y]: [&Ranged; 2]) {
        let place = |(px, py): Point| (across(frame, over_x, px), up(frame, over_y, py));
        for s in &self.series {
            let is_known = |&(low, high): &Point| self.y.scale.has(low) && self.y.scale.has(high);
            let whisker = |(point, ends): (&Point, Option<&Point>)| {
                let &(low, high) = ends.filter(|ends| is_known(ends))?;
                Some([place((point.0, low)), place((point.0, high))])
            };
            let whiskers: Vec<[Point; 2]> = self.shown_of(x, s).filter_map(whisker).collect();
            let at: Vec<Point> = self.shown_of(x, s).map(|(&point, _)| place(point)).collect();
            points(picture, s, &at, &whiskers);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::Scale;

    #[test]
    fn panels_share_their_axis_and_legend() {
        let series = |y: f64| Series::line("grid", 0, vec![(1.0, y), (100.0, 2.0 * y)]);
        let panel = |y: f64, scale| Panel { y: Axis::new("ns", scale), height: Some(80.0), series: vec![series(y)] };
        let panels = vec![panel(3.0, Scale::Log), panel(0.0, Scale::LogWithZero)];
        let x = Axis::new("a < b", Scale::Log);
        let plot = Plot { title: "t".into(), x, panels, places: vec![(10.0, "here".into())] };
        let svg = plot.picture(Format::Screen).expect("a plot").svg();
        // Two points in each, and one in the legend.
        assert_eq!((svg.matches("<circle").count(), svg.matches(">grid</text>").count()), (5, 1), "{svg}");
        assert!(svg.contains("a &lt; b") && svg.contains("here"));
        let nothing = Plot { panels: vec![Panel { series: Vec::new(), ..panel(1.0, Scale::Log) }], ..plot };
        assert!(nothing.picture(Format::Screen).is_none());
    }
}
