//! What a plot is made of: recorded while plotters draws it, then written as SVG or painted in a window.

use std::convert::Infallible;

use plotters::backend::{DrawingBackend, SVGBackend};
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea as _};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, FontTransform, IntoFont as _, RGBColor, ShapeStyle, WHITE};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind};

use super::draw::Drawn;
use crate::Error;

/// A plot, in pixels from its top left corner. It has no background: an SVG file's is white, a window has its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: (u32, u32),
    /// What is drawn, the farthest first.
    pub elements: Vec<Element>,
}

/// A form in a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Red, green and blue.
    pub color: [u8; 3],
    /// From 0 to 1.
    pub opacity: f64,
    /// The form.
    pub form: Form,
}

/// A place in a picture.
pub type Point = (i32, i32);

/// A form.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Connected segments.
    Line {
        /// Their ends.
        points: Vec<Point>,
        /// Width of the line.
        width: u32,
    },
    /// A filled polygon.
    Polygon(Vec<Point>),
    /// A rectangle.
    Rectangle {
        /// The upper left and the lower right corner.
        corners: [Point; 2],
        /// Whether it is filled, or only its outline drawn.
        is_filled: bool,
    },
    /// A circle.
    Circle {
        /// Its centre.
        center: Point,
        /// Its radius.
        radius: u32,
        /// Width of the outline; `None` if the circle is filled.
        outline: Option<u32>,
    },
    /// Text without serifs.
    Text {
        /// The text.
        text: String,
        /// The place that it is aligned to.
        at: Point,
        /// Size of the font.
        size: f64,
        /// The side of the text that lies at the place, across and down.
        align: [Side; 2],
        /// Whether it reads upwards.
        is_vertical: bool,
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

pub(super) type Area<'a> = DrawingArea<Recorder<'a>, Shift>;

impl Picture {
    /// What `draw` draws.
    pub(super) fn drawn(size: (u32, u32), draw: impl FnOnce(&Area<'_>) -> Drawn) -> Result<Self, Error> {
        let mut elements = Vec::new();
        let area = Recorder { size, elements: &mut elements }.into_drawing_area();
        let result = draw(&area);
        drop(area);
        result.map_err(|e| Error::Plot(e.to_string()))?;
        Ok(Self { size, elements })
    }

    /// As an SVG element.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<String, Error> {
        let mut svg = String::new();
        let mut backend = SVGBackend::with_string(&mut svg, self.size);
        let corner = (self.size.0 as i32, self.size.1 as i32);
        let mut drawn = backend.draw_rect((0, 0), corner, &WHITE.to_backend_color(), true);
        for element in &self.elements {
            drawn = drawn.and_then(|()| element.draw(&mut backend));
        }
        drawn.and_then(|()| backend.present()).map_err(|e| Error::Plot(e.to_string()))?;
        drop(backend);
        Ok(svg)
    }
}

impl Element {
    fn draw<B: DrawingBackend>(&self, backend: &mut B) -> Result<(), DrawingErrorKind<B::ErrorType>> {
        let [red, green, blue] = self.color;
        let color = RGBColor(red, green, blue);
        let style = |width: u32| ShapeStyle { color: color.mix(self.opacity), filled: true, stroke_width: width };
        match &self.form {
            Form::Line { points, width } => match points[..] {
                [from, to] => backend.draw_line(from, to, &style(*width)),
                _ => backend.draw_path(points.iter().copied(), &style(*width)),
            },
            Form::Polygon(points) => backend.fill_polygon(points.iter().copied(), &style(1)),
            Form::Rectangle { corners: [from, to], is_filled } => backend.draw_rect(*from, *to, &style(1), *is_filled),
            Form::Circle { center, radius, outline } => {
                backend.draw_circle(*center, *radius, &style(outline.unwrap_or(1)), outline.is_none())
            }
            Form::Text { text, at, size, align: [across, down], is_vertical } => {
                let h = [HPos::Left, HPos::Center, HPos::Right][*across as usize];
                let v = [VPos::Top, VPos::Center, VPos::Bottom][*down as usize];
                let turn = if *is_vertical { FontTransform::Rotate270 } else { FontTransform::None };
                let font = ("sans-serif", *size).into_font().transform(turn);
                backend.draw_text(text, &font.color(&color).pos(Pos::new(h, v)), *at)
            }
        }
    }
}

/// Records what plotters draws.
pub(super) struct Recorder<'a> {
    size: (u32, u32),
    elements: &'a mut Vec<Element>,
}

type Recorded = Result<(), DrawingErrorKind<Infallible>>;

impl Recorder<'_> {
    fn add(&mut self, color: BackendColor, form: Form) -> Recorded {
        let (red, green, blue) = color.rgb;
        self.elements.push(Element { color: [red, green, blue], opacity: color.alpha, form });
        Ok(())
    }
}

impl DrawingBackend for Recorder<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Recorded {
        Ok(())
    }

    fn present(&mut self) -> Recorded {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Recorded {
        self.add(color, Form::Rectangle { corners: [(x, y), (x + 1, y + 1)], is_filled: true })
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Recorded {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
        is_filled: bool,
    ) -> Recorded {
        self.add(style.color(), Form::Rectangle { corners: [from, to], is_filled })
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Recorded {
        self.add(style.color(), Form::Line { points: path.into_iter().collect(), width: style.stroke_width() })
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        is_filled: bool,
    ) -> Recorded {
        let outline = (!is_filled).then(|| style.stroke_width());
        self.add(style.color(), Form::Circle { center, radius, outline })
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Recorded {
        self.add(style.color(), Form::Polygon(path.into_iter().collect()))
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, at: BackendCoord) -> Recorded {
        let across = match style.anchor().h_pos {
            HPos::Left => Side::Start,
            HPos::Center => Side::Middle,
            HPos::Right => Side::End,
        };
        let down = match style.anchor().v_pos {
            VPos::Top => Side::Start,
            VPos::Center => Side::Middle,
            VPos::Bottom => Side::End,
        };
        let is_vertical = matches!(style.transform(), FontTransform::Rotate270);
        let form = Form::Text { text: text.to_owned(), at, size: style.size(), align: [across, down], is_vertical };
        self.add(style.color(), form)
    }
}
