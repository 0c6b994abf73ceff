//! A forest plot: a row for each name, with a point and a horizontal interval for each series.

use plotters::element::{PathElement, Rectangle};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{BLACK, Color as _};

use super::Series;
use super::axis::Axis;
use super::draw::{FRAME, Frame, GRID, PALETTE, SIZE, dashes, drawn, legend, mark, text_at};
use crate::Error;

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

/// Height of a row, in pixels.
const ROW: i32 = 38;
/// Space for names.
const LEFT: i32 = 170;

impl Forest {
    /// As an SVG element; `None` if there is nothing to show.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<Option<String>, Error> {
        let is_shown =
            |&(value, row): &(f64, f64)| self.x.scale.has(value) && row >= 0.0 && (row as usize) < self.names.len();
        let values = || self.series.iter().flat_map(|s| &s.points).filter(|p| is_shown(p)).map(|p| p.0);
        if values().count() == 0 {
            return Ok(None);
        }
        let ends = self.series.iter().flat_map(|s| &s.whiskers).flat_map(|w| [w.0, w.1]);
        let x = self.x.over(values().chain(ends).chain([self.neutral]));
        // The legend needs space, too.
        let rows = self.names.len().max(self.series.len().div_ceil(2) + 1) as i32;
        let frame = Frame { left: LEFT, bottom: FRAME.top + ROW * rows, ..FRAME };
        let size = (SIZE.0, (frame.bottom + 60) as u32);
        drawn(size, |area| {
            text_at(area, &self.title, (frame.left, 14), 16, (HPos::Left, VPos::Center))?;
            let middle = ((frame.left + frame.right) / 2, frame.bottom + 34);
            text_at(area, &self.x.label, middle, 14, (HPos::Center, VPos::Top))?;
            let at = |value: f64| frame.left + (f64::from(frame.right - frame.left) * x.part(value)).round() as i32;
            for (value, text) in x.ticks() {
                area.draw(&PathElement::new([(at(value), frame.top), (at(value), frame.bottom)], GRID))?;
                text_at(area, &text, (at(value), frame.bottom + 7), 13, (HPos::Center, VPos::Top))?;
            }
            let step = (frame.bottom - frame.top) / self.names.len().max(1) as i32;
            for (row, name) in (0..).zip(&self.names) {
                let top = frame.top + step * row;
                text_at(area, name, (frame.left - 7, top + step / 2), 13, (HPos::Right, VPos::Center))?;
                if row > 0 {
                    area.draw(&PathElement::new([(frame.left, top), (frame.right, top)], GRID))?;
                }
            }
            let neutral = at(self.neutral);
            dashes(area, &[(neutral, frame.top), (neutral, frame.bottom)], BLACK.stroke_width(1))?;
            // The series of a row lie below each other.
            let apart = step / (self.series.len() as i32 + 1);
            for (i, s) in (1..).zip(&self.series) {
                let color = PALETTE[s.color % PALETTE.len()];
                let whiskers = s.whiskers.iter().copied().chain(std::iter::repeat((f64::NAN, f64::NAN)));
                for (point, (low, high)) in s.points.iter().zip(whiskers).filter(|(point, _)| is_shown(point)) {
                    let y = frame.top + step * point.1 as i32 + apart * i;
                    if self.x.scale.has(low) && self.x.scale.has(high) {
                        let style = color.stroke_width(1);
                        area.draw(&PathElement::new([(at(low), y), (at(high), y)], style))?;
                        for end in [at(low), at(high)] {
                            area.draw(&PathElement::new([(end, y - 3), (end, y + 3)], style))?;
                        }
                    }
                    mark(area, s.mark, (at(point.0), y), color)?;
                }
            }
            area.draw(&Rectangle::new([(frame.left, frame.top), (frame.right, frame.bottom)], BLACK.stroke_width(1)))?;
            legend(area, &self.series)
        })
        .map(Some)
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
        assert!(forest(vec![]).svg().expect("no error").is_none());
        // There is no third row.
        assert!(forest(vec![(1.0, 2.0)]).svg().expect("no error").is_none());
        let svg = forest(vec![(1.2, 0.0), (0.9, 1.0)]).svg().expect("no error").expect("a plot");
        assert!(svg.contains("a &lt; b") && svg.contains("\nc\n"), "{svg}");
        // Two points and the legend's; one interval with two ends.
        assert_eq!((svg.matches("<polygon").count(), svg.matches("stroke=\"#D55E00\"").count()), (3, 3));
    }
}
