//! A picture as a page of PDF, of its size: paths only, text as outlines, no transparency, so that nothing can be missing
//! or look different anywhere.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::{Content, Filter, Finish as _, Pdf, Rect, Ref, TextStr};
use skrifa::outline::OutlinePen;

use super::font::{self, EM};
use super::picture::{Color, Element, Form, Picture, Point, begin};

impl Picture {
    /// As a PDF file with a title.
    #[must_use]
    pub fn pdf(&self, title: &str) -> Vec<u8> {
        let [catalog, pages, page, contents, info] = [1, 2, 3, 4, 5].map(Ref::new);
        let [width, height] = [self.size.0, self.size.1].map(|side| (side * self.point) as f32);
        let mut pdf = Pdf::new();
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        let mut one = pdf.page(page);
        one.media_box(Rect::new(0.0, 0.0, width, height)).parent(pages).contents(contents);
        one.resources();
        one.finish();
        let content = self.content();
        pdf.stream(contents, &content).filter(Filter::FlateDecode);
        pdf.document_info(info).title(TextStr(title)).creator(TextStr("raystep"));
        pdf.finish()
    }

    /// Its drawing instructions, compressed.
    fn content(&self) -> Vec<u8> {
        let mut content = Content::new();
        let unit = self.point as f32;
        // From here on in units, y downwards.
        content.transform([unit, 0.0, 0.0, -unit, 0.0, (self.size.1 * self.point) as f32]);
        self.elements.iter().for_each(|element| element.write(&mut content));
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::best());
        // Writing to memory cannot fail.
        let _ = packed.write_all(content.finish().as_slice());
        packed.finish().unwrap_or_default()
    }
}

impl Element {
    fn write(&self, content: &mut Content) {
        let [red, green, blue] = on_white(self.color, self.opacity);
        content.set_fill_rgb(red, green, blue).set_stroke_rgb(red, green, blue);
        match &self.form {
            Form::Line { points, width, dashes } => {
                along(content, points);
                content.set_line_width(*width as f32).set_dash_pattern(dashes.iter().copied(), 0.0).stroke();
            }
            Form::Polygon { points, outline } => {
                along(content, points);
                content.close_path();
                paint(content, *outline);
            }
            Form::Circle { center, radius, outline } => {
                circle(content, *center, *radius);
                paint(content, *outline);
            }
            Form::Text { text, at, size, align } => {
                let (x, y) = begin(text, *at, *size, *align);
                let scale = (*size / EM) as f32;
                content.save_state().transform([scale, 0.0, 0.0, -scale, x as f32, y as f32]);
                let mut pen = Pen { content, begin: 0.0, last: (0.0, 0.0) };
                font::outlines(text, &mut pen, |pen, x| pen.begin = x);
                content.fill_nonzero().restore_state();
            }
        }
    }
}

/// The colour that a transparent one has on white.
fn on_white(color: Color, opacity: f64) -> [f32; 3] {
    color.map(|part| (1.0 - opacity * (1.0 - f64::from(part) / 255.0)) as f32)
}

fn paint(content: &mut Content, outline: Option<f64>) {
    match outline {
        Some(width) => content.set_line_width(width as f32).set_dash_pattern([], 0.0).stroke(),
        None => content.fill_nonzero(),
    };
}

fn along(content: &mut Content, points: &[Point]) {
    for (i, &(x, y)) in points.iter().enumerate() {
        let (x, y) = (x as f32, y as f32);
        if i == 0 {
            content.move_to(x, y)
        } else {
            content.line_to(x, y)
        };
    }
}

/// Four Bézier curves.
fn circle(content: &mut Content, (x, y): Point, radius: f64) {
    // The usual one: off by at most 0.03% of the radius.
    const HANDLE: f64 = 0.552_284_75;
    let (x, y, r, h) = (x as f32, y as f32, radius as f32, (HANDLE * radius) as f32);
    content.move_to(x + r, y);
    content.cubic_to(x + r, y + h, x + h, y + r, x, y + r);
    content.cubic_to(x - h, y + r, x - r, y + h, x - r, y);
    content.cubic_to(x - r, y - h, x - h, y - r, x, y - r);
    content.cubic_to(x + h, y - r, x + r, y - h, x + r, y);
    content.close_path();
}

/// Writes outlines of glyphs.
struct Pen<'a> {
    content: &'a mut Content,
    /// Where the glyph begins.
    begin: f32,
    last: (f32, f32),
}

impl OutlinePen for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.last = (x, y);
        self.content.move_to(self.begin + x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.last = (x, y);
        self.content.line_to(self.begin + x, y);
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        // The same curve as a cubic one. Rounding to whole units, 1/170 of a pixel on paper, makes files shorter.
        let toward = |from: f32, control: f32| (from + 2.0 * (control - from) / 3.0).round();
        let (from, to) = (self.last, (x, y));
        let [first, second] = [from, to].map(|end| (toward(end.0, cx), toward(end.1, cy)));
        self.curve_to(first.0, first.1, second.0, second.1, x, y);
    }

    fn curve_to(&mut self, cx0: f32, cy0: f32, cx1: f32, cy1: f32, x: f32, y: f32) {
        self.last = (x, y);
        let begin = self.begin;
        self.content.cubic_to(begin + cx0, cy0, begin + cx1, cy1, begin + x, y);
    }

    fn close(&mut self) {
        self.content.close_path();
    }
}
