//! Series of points over an axis.

use super::draw::{above, across, below, beside, columns, left_of, points, up, upright};
use super::frame::Frame;
use super::legend::{entries, head, places};
use super::picture::{Picture, Point};
use super::{Axis, Draw, Format, Series};

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

/// Width on a screen.
pub(super) const WIDTH: f64 = 860.0;
/// Right of a plot.
pub(super) const RIGHT: f64 = 12.0;

/// Height of a plot in a picture of a width.
fn height(width: f64) -> f64 {
    (0.5 * width).clamp(190.0, 290.0)
}

impl Draw for Plot {
    fn title(&self) -> &str {
        &self.title
    }

    fn picture(&self, format: Format) -> Option<Picture> {
        let is_shown = |&(x, y): &Point| self.x.scale.has(x) && self.y.scale.has(y);
        let all = || self.series.iter().flat_map(|s| &s.points).filter(|point| is_shown(point));
        all().next()?;
        let ends = self.series.iter().flat_map(|s| &s.whiskers).flat_map(|w| [w.0, w.1]);
        let x = self.x.over(all().map(|p| p.0).chain(self.places.iter().map(|p| p.0)));
        let y = self.y.over(all().map(|p| p.1).chain(ends));
        let mut picture = Picture::new(format, WIDTH);
        let (positions, named): (Vec<f64>, Vec<_>) = places(&self.places).unzip();
        let legend: Vec<_> = entries(self.series.iter()).into_iter().chain(named).collect();
        let top = head(&mut picture, &self.title, &legend);
        let top = above(&mut picture, &self.y.label, top);
        let height = height(picture.width());
        let (rows, left) = left_of(&y, height);
        let frame = Frame { left, right: picture.width() - RIGHT, top, bottom: top + height };
        let columns = columns(&picture, frame, &x);
        upright(&mut picture, frame, &x, &columns);
        beside(&mut picture, frame, &y, &rows);
        for (value, entry) in positions.iter().zip(&legend[legend.len() - positions.len()..]) {
            entry.draw_along(&mut picture, across(frame, &x, *value), [frame.top, frame.bottom]);
        }
        let place = |(px, py): Point| (across(frame, &x, px), up(frame, &y, py));
        for s in &self.series {
            let whiskers = s.points.iter().zip(&s.whiskers).filter(|(point, _)| is_shown(point));
            let is_known = |&(_, &(low, high)): &(&Point, &Point)| self.y.scale.has(low) && self.y.scale.has(high);
            let whiskers =
                whiskers.filter(is_known).map(|(&(px, _), &(low, high))| [place((px, low)), place((px, high))]);
            let whiskers: Vec<[Point; 2]> = whiskers.collect();
            let at: Vec<Point> = s.points.iter().filter(|point| is_shown(point)).map(|&point| place(point)).collect();
            points(&mut picture, s, &at, &whiskers);
        }
        picture.border(frame);
        picture.size.1 = below(&mut picture, frame, &x, &columns, &self.x.label);
        Some(picture)
    }
}
