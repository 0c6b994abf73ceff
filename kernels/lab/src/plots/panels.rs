//! Small plots, one above the other, over a common horizontal axis.

use super::axis::Ranged;
use super::draw::{above, across, below, beside, columns, left_of, points, up, upright};
use super::frame::Frame;
use super::legend::{Entry, entries, head, places};
use super::lines::RIGHT;
use super::picture::{Picture, Point};
use super::{Axis, Draw, Format, Series};

/// Width on a screen.
const WIDTH: f64 = 440.0;

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
    /// Height in units.
    pub height: f64,
    /// In drawing order. Names of all panels' series are shown once, above the first.
    pub series: Vec<Series>,
}

impl Draw for Panels {
    fn title(&self) -> &str {
        &self.title
    }

    fn picture(&self, format: Format) -> Option<Picture> {
        let all = || self.panels.iter().flat_map(|p| p.series.iter().flat_map(|s| s.points.iter().map(|&p| p.0)));
        all().find(|&x| self.x.scale.has(x))?;
        let x = self.x.over(all().chain(self.places.iter().map(|p| p.0)));
        let mut picture = Picture::new(format, WIDTH);
        let series = || self.panels.iter().flat_map(|panel| &panel.series);
        let (positions, named): (Vec<f64>, Vec<Entry>) = places(&self.places).unzip();
        let legend: Vec<Entry> = entries(series()).into_iter().chain(named.iter().cloned()).collect();
        let mut top = head(&mut picture, &self.title, &legend);
        let ranges: Vec<Ranged> = self.panels.iter().map(Panel::range).collect();
        let rows: Vec<_> = self.panels.iter().zip(&ranges).map(|(panel, y)| left_of(y, panel.height)).collect();
        let left = rows.iter().map(|(_, left)| *left).fold(0.0, f64::max);
        let mut frame = Frame { left, right: picture.width() - RIGHT, top, bottom: top };
        let columns = columns(&picture, frame, &x);
        for ((panel, y), (rows, _)) in self.panels.iter().zip(&ranges).zip(&rows) {
            frame.top = above(&mut picture, &panel.y.label, top);
            frame.bottom = frame.top + panel.height;
            upright(&mut picture, frame, &x, &columns);
            beside(&mut picture, frame, y, rows);
            for (value, entry) in positions.iter().zip(&named) {
                entry.draw_along(&mut picture, across(frame, &x, *value), [frame.top, frame.bottom]);
            }
            panel.draw(&mut picture, frame, &x, y);
            picture.border(frame);
            top = frame.bottom + 4.0;
        }
        picture.size.1 = below(&mut picture, frame, &x, &columns, &self.x.label);
        Some(picture)
    }
}

impl Panel {
    fn range(&self) -> Ranged {
        let points = self.series.iter().flat_map(|s| s.points.iter().map(|p| p.1));
        let ends = self.series.iter().flat_map(|s| &s.whiskers).flat_map(|w| [w.0, w.1]);
        self.y.over(points.chain(ends))
    }

    fn draw(&self, picture: &mut Picture, frame: Frame, x: &Ranged, y: &Ranged) {
        for s in &self.series {
            let is_shown = |&(px, py): &Point| self.y.scale.has(py) && px.is_finite();
            let place = |(px, py): Point| (across(frame, x, px), up(frame, y, py));
            let shown = s.points.iter().zip(&s.whiskers).filter(|(point, _)| is_shown(point));
            let whiskers = shown.map(|(&(px, _), &(low, high))| [place((px, low)), place((px, high))]);
            let whiskers: Vec<[Point; 2]> = whiskers.collect();
            let at: Vec<Point> = s.points.iter().filter(|point| is_shown(point)).map(|&point| place(point)).collect();
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
        let panel = |y: f64, scale| Panel { y: Axis::new("ns", scale), height: 80.0, series: vec![series(y)] };
        let panels = vec![panel(3.0, Scale::Log), panel(0.0, Scale::LogWithZero)];
        let x = Axis::new("a < b", Scale::Log);
        let plot = Panels { title: "t".into(), x, panels, places: vec![(10.0, "here".into())] };
        let svg = plot.picture(Format::Screen).expect("a plot").svg();
        // Two points in each, and one in the legend.
        assert_eq!((svg.matches("<circle").count(), svg.matches(">grid</text>").count()), (5, 1), "{svg}");
        assert!(svg.contains("a &lt; b") && svg.contains("here"));
        let nothing = Panels { panels: vec![Panel { series: Vec::new(), ..panel(1.0, Scale::Log) }], ..plot };
        assert!(nothing.picture(Format::Screen).is_none());
    }
}
