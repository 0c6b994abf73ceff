//! A bar chart.

use super::draw::{MARGIN, across, below, color, columns, upright, widest};
use super::font::wrapped;
use super::frame::Frame;
use super::legend::{Entry, Symbol, head};
use super::lines::{RIGHT, WIDTH};
use super::picture::{LINE, Picture, SIZE, Side};
use super::{Axis, Draw, Format, Scale};

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

/// Names of rows beside a plot: their lines, and the plot's left side.
pub(super) fn names(width: f64, names: &[&str]) -> (Vec<Vec<String>>, f64) {
    let lines: Vec<Vec<String>> = names.iter().map(|name| wrapped(name, SIZE, 0.4 * width)).collect();
    let left = MARGIN + lines.iter().map(|lines| widest(lines)).fold(0.0, f64::max) + 6.0;
    (lines, left)
}

/// Heights of rows: what their names need, but no less than `least`.
pub(super) fn heights(names: &[Vec<String>], least: f64) -> Vec<f64> {
    names.iter().map(|lines| (LINE * lines.len() as f64 + 4.0).max(least)).collect()
}

/// A row's name beside it, around a height.
pub(super) fn name(picture: &mut Picture, lines: &[String], left: f64, middle: f64) {
    let first = middle - LINE * (lines.len() as f64 - 1.0) / 2.0;
    picture.lines(lines, (left - 6.0, first), [Side::End, Side::Middle]);
}

impl Draw for Bars {
    fn title(&self) -> &str {
        &self.title
    }

    fn picture(&self, format: Format) -> Option<Picture> {
        let length = |parts: &[Part]| parts.iter().map(|p| p.0).sum::<f64>();
        let longest = self.bars.iter().map(|b| length(&b.1)).fold(0.0, f64::max);
        if longest <= 0.0 || !longest.is_finite() {
            return None;
        }
        let mut picture = Picture::new(format, WIDTH);
        let x = Axis::new(self.x.clone(), Scale::Linear).over([0.0, longest].into_iter());
        let entry = |(i, name): (usize, &String)| Entry { name: name.clone(), color: color(i), symbol: Symbol::Area };
        let legend: Vec<Entry> = self.legend.iter().enumerate().map(entry).collect();
        let top = head(&mut picture, &self.title, &legend) + 4.0;
        let bars: Vec<&str> = self.bars.iter().map(|(name, _)| name.as_str()).collect();
        let (lines, left) = names(picture.width(), &bars);
        let heights = heights(&lines, 26.0);
        let frame = Frame { left, right: picture.width() - RIGHT, top, bottom: top + heights.iter().sum::<f64>() };
        let columns = columns(&picture, frame, &x);
        upright(&mut picture, frame, &x, &columns);
        let mut above = top;
        for (((_, parts), lines), height) in self.bars.iter().zip(&lines).zip(heights) {
            let middle = above + height / 2.0;
            name(&mut picture, lines, left, middle);
            let mut begin = 0.0;
            for &(part, of) in parts {
                let [from, to] = [begin, begin + part].map(|value| across(frame, &x, value));
                let bar = Frame { left: from, right: to, top: middle - 8.0, bottom: middle + 8.0 };
                picture.filled(color(of), 1.0, bar);
                begin += part;
            }
            above += height;
        }
        picture.border(frame);
        picture.size.1 = below(&mut picture, frame, &x, &columns, &self.x);
        Some(picture)
    }
}
