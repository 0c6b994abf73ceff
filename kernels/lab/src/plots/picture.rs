//! What a plot is made of, for files and for windows.

use super::Format;
use super::font::{self, MIDDLE, REACH};
use super::frame::Frame;
use crate::text::visible;

/// A plot, in units from its top left corner. It has no background: an SVG file's is white, a window has its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: (f64, f64),
    /// Points (1/72 inch) of a unit.
    pub point: f64,
    /// What is drawn, the farthest first.
    pub elements: Vec<Element>,
}

/// A form in a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Red, green and blue.
    pub color: Color,
    /// From 0 to 1.
    pub opacity: f64,
    /// The form.
    pub form: Form,
}

/// Red, green and blue.
pub type Color = [u8; 3];

/// A place in a picture.
pub type Point = (f64, f64);

/// Lengths of dashes and gaps in turn; none for a solid line.
pub type Dashes = &'static [f32];

/// A form.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Connected segments.
    Line {
        /// Their ends.
        points: Vec<Point>,
        /// Width of the line.
        width: f64,
        /// Its dashes.
        dashes: Dashes,
    },
    /// A convex polygon.
    Polygon {
        /// Its corners.
        points: Vec<Point>,
        /// Width of the outline; `None` if the polygon is filled.
        outline: Option<f64>,
    },
    /// A circle.
    Circle {
        /// Its centre.
        center: Point,
        /// Its radius.
        radius: f64,
        /// Width of the outline; `None` if the circle is filled.
        outline: Option<f64>,
    },
    /// A line of text without serifs.
    Text {
        /// The text.
        text: String,
        /// The place that it is aligned to.
        at: Point,
        /// Size of the font.
        size: f64,
        /// The side of the text that lies at the place, across and down.
        align: [Side; 2],
    },
}

/// A side of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Left, or top.
    Start,
    /// The middle.
    Middle,
    /// Right, or bottom.
    End,
}

/// Size of most texts.
pub(super) const SIZE: f64 = 12.0;
/// Between baselines.
pub(super) const LINE: f64 = 15.0;
/// Width of thin and of thick lines.
pub(super) const THIN: f64 = 1.0;
pub(super) const THICK: f64 = 1.8;

pub(super) const BLACK: Color = [0, 0, 0];
pub(super) const WHITE: Color = [255, 255, 255];
/// Of lines behind the data.
pub(super) const GRID: Color = [230, 230, 230];

impl Picture {
    /// An empty picture of a width; its height is set when everything is drawn.
    pub(super) fn new(format: Format, screen: f64) -> Self {
        Self { size: (format.width(screen), 0.0), point: format.point(), elements: Vec::new() }
    }

    pub(super) fn width(&self) -> f64 {
        self.size.0
    }

    /// Whether it is for a screen.
    pub(super) fn is_screen(&self) -> bool {
        self.point == Format::Screen.point()
    }

    /// Draws the next form.
    pub(super) fn add(&mut self, color: Color, opacity: f64, form: Form) {
        self.elements.push(Element { color, opacity, form });
    }

    pub(super) fn line(&mut self, color: Color, width: f64, dashes: Dashes, points: &[Point]) {
        if points.len() > 1 {
            self.add(color, 1.0, Form::Line { points: points.to_vec(), width, dashes });
        }
    }

    pub(super) fn thin(&mut self, color: Color, from: Point, to: Point) {
        self.line(color, THIN, &[], &[from, to]);
    }

    pub(super) fn filled(&mut self, color: Color, opacity: f64, frame: Frame) {
        self.add(color, opacity, Form::Polygon { points: frame.corners().to_vec(), outline: None });
    }

    /// The outline of a plot.
    pub(super) fn border(&mut self, frame: Frame) {
        self.add(BLACK, 1.0, Form::Polygon { points: frame.corners().to_vec(), outline: Some(THIN) });
    }

    pub(super) fn text(&mut self, text: &str, at: Point, align: [Side; 2]) {
        self.sized(text, at, SIZE, align);
    }

    pub(super) fn sized(&mut self, text: &str, at: Point, size: f64, align: [Side; 2]) {
        if !text.is_empty() {
            self.add(BLACK, 1.0, Form::Text { text: visible(text).into_owned(), at, size, align });
        }
    }

    /// Lines one below the other, the first at this place.
    pub(super) fn lines(&mut self, lines: &[String], at: Point, align: [Side; 2]) {
        for (line, i) in lines.iter().zip(0_u8..) {
            self.text(line, (at.0, at.1 + LINE * f64::from(i)), align);
        }
    }
}

/// The left end of a text and its baseline.
pub(super) fn begin(text: &str, at: Point, size: f64, [across, down]: [Side; 2]) -> Point {
    let width = font::width(text, size);
    let x = match across {
        Side::Start => at.0,
        Side::Middle => at.0 - width / 2.0,
        Side::End => at.0 - width,
    };
    let y = match down {
        Side::Start => at.1 + REACH[0] * size,
        Side::Middle => at.1 + MIDDLE * size,
        Side::End => at.1 - REACH[1] * size,
    };
    (x, y)
}

impl Form {
    /// What a text covers; `None` of other forms.
    #[must_use]
    pub fn text_box(&self) -> Option<Frame> {
        let Self::Text { text, at, size, align } = self else { return None };
        let (left, baseline) = begin(text, *at, *size, *align);
        let [above, below] = REACH.map(|reach| reach * size);
        Some(Frame { left, right: left + font::width(text, *size), top: baseline - above, bottom: baseline + below })
    }
}
