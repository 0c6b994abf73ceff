//! A forest plot: a row for each name, with a point and a horizontal interval for each series.

use super::axis::Axis;
use super::bars::{heights, name, names};
use super::draw::{across, below, columns, points, upright};
use super::frame::Frame;
use super::legend::{entries, head};
use super::lines::{RIGHT, WIDTH};
use super::picture::{BLACK, GRID, Picture, Point, THIN};
use super::{Draw, Format, Series};

/// Values with their intervals, by name.
#[derive(Clone, Debug)]
pub struct Forest {
    /// Heading.
    pub title: String,
    /// The axis of values.
    pub x: Axis,
    /// The rows, from top to bottom.
    pub names: Vec<String>,
    /// The value that means no difference.
    pub neutral: f64,
    /// What is drawn: of a point (x, y), x is the value, and y the row, counted from 0; whiskers are along x. A whisker
    /// that is NaN is not drawn.
    pub series: Vec<Series>,
}

/// Height of a series in a row.
const EACH: f64 = 11.0;

impl Draw for Forest {
    fn title(&self) -> &str {
        &self.title
    }

    fn picture(&self, format: Format) -> Option<Picture> {
        let is_shown =
            |&(value, row): &Point| self.x.scale.has(value) && row >= 0.0 && (row as usize) < self.names.len();
        let values = || self.series.iter().flat_map(|s| &s.points).filter(|p| is_shown(p)).map(|p| p.0);
        values().next()?;
        let ends = self.series.iter().flat_map(|s| &s.whiskers).flat_map(|w| [w.0, w.1]);
        let x = self.x.over(values().chain(ends).chain([self.neutral]));
        let mut picture = Picture::new(format, WIDTH);
        let top = head(&mut picture, &self.title, &entries(self.series.iter())) + 4.0;
        let rows: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let (lines, left) = names(picture.width(), &rows);
        let heights = heights(&lines, EACH * (self.series.len() as f64 + 1.0));
        let frame = Frame { left, right: picture.width() - RIGHT, top, bottom: top + heights.iter().sum::<f64>() };
        let columns = columns(&picture, frame, &x);
        upright(&mut picture, frame, &x, &columns);
        let mut begin = top;
        let mut middles = Vec::new();
        for (lines, height) in lines.iter().zip(heights) {
            if begin > top {
                picture.thin(GRID, (frame.left, begin), (frame.right, begin));
            }
            name(&mut picture, lines, left, begin + height / 2.0);
            middles.push(begin + height / 2.0);
            begin += height;
        }
        let neutral = across(frame, &x, self.neutral);
        picture.line(BLACK, THIN, &[7.0, 4.0], &[(neutral, frame.top), (neutral, frame.bottom)]);
        for (i, s) in self.series.iter().enumerate() {
            // The series of a row lie below each other.
            let down = EACH * (i as f64 + 0.5 - self.series.len() as f64 / 2.0);
            let place = |value: f64, row: f64| (across(frame, &x, value), middles[row as usize] + down);
            let shown = || s.points.iter().enumerate().filter(|(_, point)| is_shown(point));
            let whisker = |(i, &(_, row)): (usize, &Point)| {
                let &(low, high) = s.whiskers.get(i)?;
                let is_known = self.x.scale.has(low) && self.x.scale.has(high);
                is_known.then(|| [place(low, row), place(high, row)])
            };
            let whiskers: Vec<[Point; 2]> = shown().filter_map(whisker).collect();
            let at: Vec<Point> = shown().map(|(_, &(value, row))| place(value, row)).collect();
            points(&mut picture, s, &at, &whiskers);
        }
        picture.border(frame);
        picture.size.1 = below(&mut picture, frame, &x, &columns, &self.x.label);
        Some(picture)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Mark, Scale, Stroke};
    use super::*;

    #[test]
    fn every_name_has_a_row_and_only_known_intervals_are_drawn() {
        let forest = |points: Vec<(f64, f64)>| Forest {
            title: "t".into(),
            x: Axis::new("ratio", Scale::Linear),
            names: vec!["a < b".into(), "c".into()],
            neutral: 1.0,
            series: vec![Series {
                name: "s".into(),
                points,
                whiskers: vec![(1.1, 1.3), (f64::NAN, f64::NAN)],
                color: 1,
                mark: Mark::Triangle,
                stroke: Stroke::None,
            }],
        };
        let svg = |points| forest(points).picture(Format::Screen).map(|picture| picture.svg());
        assert!(svg(vec![]).is_none());
        // There is no third row.
        assert!(svg(vec![(1.0, 2.0)]).is_none());
        let svg = svg(vec![(1.2, 0.0), (0.9, 1.0)]).expect("a plot");
        assert!(svg.contains("a &lt; b") && svg.contains(">c</text>"), "{svg}");
        // Two points, the legend's, and the border; one interval with two ends.
        assert_eq!((svg.matches("<polygon").count(), svg.matches("stroke=\"#D55E00\"").count()), (4, 3), "{svg}");
    }
}
