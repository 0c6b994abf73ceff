//! Draws the picture: the bands form stairs, so that arrows from above can reach each band at its step.

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea as _};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color as _, FontStyle, FontTransform, IntoFont as _, IntoTextStyle as _, RGBColor, ShapeStyle, WHITE,
};

use super::{Picture, Row, STOPS};

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;
type Point = (i32, i32);

/// Monospaced fonts; in each of them a letter is at most [`LETTER`] wide at a size of 12 pixels.
const CODE: &str = "ui-monospace, Menlo, Consolas, monospace";
const PROSE: &str = "system-ui, Helvetica, Arial, sans-serif";
const LETTER: f64 = 7.3;

const WIDTH: i32 = 924;
/// Left ends of the columns.
const MARGIN: i32 = 12;
const FLOORS_AT: i32 = 38;
const NAMES_AT: i32 = 48;
const MODULES_AT: i32 = 140;
const LABELS_AT: i32 = 334;
const RUN_AT: i32 = 522;
/// Distance between two stops.
const PITCH: i32 = 14;
/// The right end of the highest band, and how much longer each band is than the one above it.
const STAIRS_AT: i32 = 706;
const STEP: i32 = 11;
/// The top of the highest band, the height of a line, the margin above and below a band's lines, and the legend.
const TOP: i32 = 58;
const LINE: i32 = 16;
const PADDING: i32 = 14;
const LEGEND: i32 = 64;

const INK: RGBColor = RGBColor(31, 35, 40);
const FAINT: RGBColor = RGBColor(87, 96, 106);
const EDGE: RGBColor = RGBColor(208, 215, 222);
const ARROW: RGBColor = RGBColor(172, 180, 190);
const DOT: RGBColor = RGBColor(96, 108, 122);
const FLOOR: [RGBColor; 2] = [RGBColor(233, 240, 249), RGBColor(223, 233, 245)];
const KERNELS: RGBColor = RGBColor(190, 208, 231);
const CRATE: RGBColor = RGBColor(244, 238, 224);
const RUN: RGBColor = RGBColor(190, 75, 0);

/// Minimum number of uses for a dot, and its radius. There are only a few sizes, so that most changes of a `use` do not
/// change the picture.
const DOTS: [(usize, i32); 3] = [(1, 2), (5, 3), (25, 5)];

struct Style {
    font: &'static str,
    size: i32,
    color: RGBColor,
    is_bold: bool,
}

const NAME: Style = Style { font: CODE, size: 13, color: INK, is_bold: true };
const MODULE: Style = Style { font: CODE, size: 12, color: FAINT, is_bold: false };
const ABOUT: Style = Style { font: PROSE, size: 12, color: FAINT, is_bold: false };
const LABEL: Style = Style { font: CODE, size: 12, color: RUN, is_bold: false };
const NUMBER: Style = Style { font: PROSE, size: 12, color: RUN, is_bold: true };
const NOTE: Style = Style { font: PROSE, size: 13, color: FAINT, is_bold: false };
const TITLE: Style = Style { font: PROSE, size: 17, color: INK, is_bold: true };

/// A band with its position.
struct Band<'a> {
    row: &'a Row,
    /// Each part's name and lines.
    parts: Vec<(&'a str, Vec<String>)>,
    top: i32,
    bottom: i32,
    right: i32,
}

impl Band<'_> {
    fn middle(&self) -> i32 {
        (self.top + self.bottom) / 2
    }

    /// The middle of the step at which arrows from above reach it.
    fn step(&self) -> i32 {
        self.right - STEP / 2
    }
}

/// The picture as an SVG file.
pub(super) fn svg(picture: &Picture) -> Result<String, Box<dyn std::error::Error>> {
    let bands = bands(picture);
    let height = bands.last().map_or(TOP, |band| band.bottom) + LEGEND;
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (WIDTH as u32, height as u32)).into_drawing_area();
        area.fill(&WHITE)?;
        area.draw(&Rectangle::new([(0, 0), (WIDTH - 1, height - 1)], EDGE.stroke_width(1)))?;
        headings(&area)?;
        for (i, band) in bands.iter().enumerate() {
            draw_band(&area, band, i)?;
        }
        draw_kernels(&area, &bands)?;
        arrows(&area, picture, &bands)?;
        labels(&area, picture, &bands)?;
        run(&area, picture, &bands)?;
        legend(&area, height - LEGEND)?;
        area.present()?;
    }
    Ok(svg)
}

fn bands(picture: &Picture) -> Vec<Band<'_>> {
    let mut top = TOP;
    let mut bands = Vec::new();
    for (i, row) in picture.rows.iter().enumerate() {
        let stops = STOPS.iter().zip(&picture.stops).filter(|&(_, &at)| at == i);
        let labels: usize = stops.map(|(stop, _)| stop.lines()).sum();
        let end = if labels > 0 { LABELS_AT } else { RUN_AT - PITCH };
        let lines = |words: &[String]| if row.is_floor { wrapped(words, end) } else { words.to_vec() };
        let parts: Vec<(&str, Vec<String>)> = row.parts.iter().map(|(name, words)| (&**name, lines(words))).collect();
        let modules: usize = parts.iter().map(|(_, lines)| lines.len().max(1)).sum();
        let bottom = top + LINE * modules.max(labels) as i32 + PADDING;
        bands.push(Band { row, parts, top, bottom, right: STAIRS_AT + STEP * i as i32 });
        // A larger gap separates crates from the floors.
        let next = picture.rows.get(i + 1);
        top = bottom + if next.is_some_and(|next| next.is_floor && row.is_floor) { 2 } else { 6 };
    }
    bands
}

/// Breaks words into lines that fit between the column of modules and `end`.
fn wrapped(words: &[String], end: i32) -> Vec<String> {
    let most = (f64::from(end - MODULES_AT - 8) / LETTER) as usize;
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= most => *line += &format!(" {word}"),
            _ => lines.push(word.clone()),
        }
    }
    lines
}

fn text(area: &Area<'_>, text: &str, at: Point, style: &Style, h: HPos) -> Drawn {
    // plotters divides font sizes by this factor.
    let font = (style.font, f64::from(style.size) * 1.24).into_font();
    let font = if style.is_bold { font.style(FontStyle::Bold) } else { font };
    area.draw(&Text::new(text.to_owned(), at, font.color(&style.color).pos(Pos::new(h, VPos::Center))))?;
    Ok(())
}

fn line(area: &Area<'_>, points: &[Point], style: ShapeStyle) -> Drawn {
    // One segment at a time: some viewers fill longer lines like shapes.
    for pair in points.windows(2).filter(|pair| pair[0] != pair[1]) {
        area.draw(&PathElement::new([pair[0], pair[1]], style))?;
    }
    Ok(())
}

/// A horizontal or vertical line of dashes.
fn dashed(area: &Area<'_>, from: Point, to: Point, style: ShapeStyle) -> Drawn {
    let length = (to.0 - from.0).abs().max((to.1 - from.1).abs());
    let (dx, dy) = ((to.0 - from.0).signum(), (to.1 - from.1).signum());
    for begin in (0..length).step_by(6) {
        let at = |along: i32| (from.0 + dx * along, from.1 + dy * along);
        line(area, &[at(begin), at((begin + 3).min(length))], style)?;
    }
    Ok(())
}

/// An arrowhead with its tip at (x, y), pointing along (dx, dy).
fn head(area: &Area<'_>, (x, y): Point, (dx, dy): Point, size: i32, color: RGBColor) -> Drawn {
    let (back_x, back_y) = (x - dx * size, y - dy * size);
    let half = (size + 1) / 2;
    let points = [(x, y), (back_x - dy * half, back_y - dx * half), (back_x + dy * half, back_y + dx * half)];
    area.draw(&Polygon::new(points, color.filled()))?;
    Ok(())
}

fn headings(area: &Area<'_>) -> Drawn {
    text(area, "What stands on what, and where a frame goes", (MARGIN, 20), &TITLE, HPos::Left)?;
    text(area, "crates, and the modules of kernels", (MARGIN, 44), &NOTE, HPos::Left)?;
    let run = Style { color: RUN, ..NOTE };
    text(area, "a run, left to right: raystep render SCENE -o OUT.png", (LABELS_AT, 44), &run, HPos::Left)?;
    text(area, "what each uses", (WIDTH - MARGIN, 44), &NOTE, HPos::Right)
}

fn draw_band(area: &Area<'_>, band: &Band<'_>, i: usize) -> Drawn {
    let (left, color) = if band.row.is_floor { (FLOORS_AT, FLOOR[i % 2]) } else { (MARGIN, CRATE) };
    area.draw(&Rectangle::new([(left, band.top), (band.right, band.bottom)], color.filled()))?;
    let name_at = if band.row.is_floor { NAMES_AT } else { MARGIN + 10 };
    let about = if band.row.is_floor { MODULE } else { ABOUT };
    let lines: usize = band.parts.iter().map(|(_, lines)| lines.len().max(1)).sum();
    let mut y = band.middle() - LINE * (lines as i32 - 1) / 2;
    for (name, lines) in &band.parts {
        text(area, name, (name_at, y), &NAME, HPos::Left)?;
        for line in lines {
            text(area, line, (MODULES_AT, y), &about, HPos::Left)?;
            y += LINE;
        }
        y += if lines.is_empty() { LINE } else { 0 };
    }
    Ok(())
}

/// The bar at the left of all floors, labelled with their crate.
fn draw_kernels(area: &Area<'_>, bands: &[Band<'_>]) -> Drawn {
    let floors = || bands.iter().filter(|band| band.row.is_floor);
    let (Some(first), Some(last)) = (floors().next(), floors().next_back()) else { return Ok(()) };
    area.draw(&Rectangle::new([(MARGIN, first.top), (FLOORS_AT - 2, last.bottom)], KERNELS.filled()))?;
    let font = (NAME.font, f64::from(NAME.size) * 1.24).into_font().style(FontStyle::Bold);
    let style = font.transform(FontTransform::Rotate270).into_text_style(area).color(&NAME.color);
    let style = style.pos(Pos::new(HPos::Center, VPos::Center));
    area.draw(&Text::new("kernels", ((MARGIN + FLOORS_AT - 2) / 2, (first.top + last.bottom) / 2), style))?;
    Ok(())
}

/// From each band a line to the right, with a dot above the step of each band that it uses and an arrow down to it.
fn arrows(area: &Area<'_>, picture: &Picture, bands: &[Band<'_>]) -> Drawn {
    let style = ARROW.stroke_width(1);
    for (i, band) in bands.iter().enumerate() {
        let used = picture.uses.keys().filter(|&&(from, _)| from == i).map(|&(_, to)| bands[to].step());
        if let Some(farthest) = used.max() {
            line(area, &[(band.right, band.middle()), (farthest, band.middle())], style)?;
        }
        let users = picture.uses.keys().filter(|&&(_, to)| to == i).map(|&(from, _)| bands[from].middle());
        if let Some(highest) = users.min() {
            line(area, &[(band.step(), highest), (band.step(), band.top - 1)], style)?;
            head(area, (band.step(), band.top), (0, 1), 6, DOT)?;
        }
    }
    for (&(from, to), &uses) in &picture.uses {
        let radius = DOTS.iter().rev().find(|&&(least, _)| uses >= least).map_or(1, |&(_, radius)| radius);
        area.draw(&Circle::new((bands[to].step(), bands[from].middle()), radius, DOT.filled()))?;
    }
    Ok(())
}

/// Names of stops, beside the modules of their bands.
fn labels(area: &Area<'_>, picture: &Picture, bands: &[Band<'_>]) -> Drawn {
    for (i, band) in bands.iter().enumerate() {
        let here = || STOPS.iter().enumerate().filter(|&(at, _)| picture.stops[at] == i);
        let lines: usize = here().map(|(_, stop)| stop.lines()).sum();
        let mut y = band.middle() - LINE * (lines as i32 - 1) / 2;
        for (at, stop) in here() {
            text(area, &(at + 1).to_string(), (LABELS_AT + 14, y), &NUMBER, HPos::Right)?;
            for label in stop.labels() {
                text(area, &label, (LABELS_AT + 22, y), &LABEL, HPos::Left)?;
                y += LINE;
            }
            text(area, stop.about, (LABELS_AT + 22, y), &ABOUT, HPos::Left)?;
            y += LINE;
        }
    }
    Ok(())
}

/// The path from stop to stop: from each one up or down, then to the right.
fn run(area: &Area<'_>, picture: &Picture, bands: &[Band<'_>]) -> Drawn {
    const RADIUS: i32 = 9;
    let style = RUN.stroke_width(2);
    let place = |stop: usize| (RUN_AT + PITCH * stop as i32, bands[picture.stops[stop]].middle());
    for (i, stop) in STOPS.iter().enumerate() {
        let (x, y) = place(i);
        if let Some(next) = (i + 1..STOPS.len()).find(|&next| !STOPS[next].is_optional) {
            let (next_x, next_y) = place(next);
            if stop.is_optional {
                dashed(area, (x, y), (x, next_y), RUN.stroke_width(1))?;
            } else {
                line(area, &[(x, y), (x, next_y), (next_x, next_y)], style)?;
                head(area, (next_x - RADIUS + 1, next_y), (1, 0), 6, RUN)?;
            }
        }
        if stop.is_optional && i > 0 {
            dashed(area, (place(i - 1).0, y), (x, y), RUN.stroke_width(1))?;
        }
        if let Some(turn) = stop.turns_to {
            let (to_x, to_y) = place(turn);
            dashed(area, (x, y), (x, to_y), style)?;
            dashed(area, (x, to_y), (to_x, to_y), style)?;
            head(area, (to_x + RADIUS - 1, to_y), (-1, 0), 6, RUN)?;
        }
    }
    for (i, stop) in STOPS.iter().enumerate() {
        let at = place(i);
        area.draw(&Circle::new(at, RADIUS, if stop.is_optional { WHITE } else { RUN }.filled()))?;
        area.draw(&Circle::new(at, RADIUS, RUN.stroke_width(1)))?;
        let number = Style { color: if stop.is_optional { RUN } else { WHITE }, ..NUMBER };
        text(area, &(i + 1).to_string(), at, &number, HPos::Center)?;
    }
    Ok(())
}

fn legend(area: &Area<'_>, top: i32) -> Drawn {
    let (first, second) = (top + 20, top + 44);
    let style = RUN.stroke_width(2);
    line(area, &[(MARGIN, first), (MARGIN + 28, first)], style)?;
    head(area, (MARGIN + 32, first), (1, 0), 6, RUN)?;
    text(area, "to the next stop", (MARGIN + 40, first), &NOTE, HPos::Left)?;
    dashed(area, (MARGIN + 170, first), (MARGIN + 198, first), style)?;
    head(area, (MARGIN + 202, first), (1, 0), 6, RUN)?;
    text(area, "to the next passes, while rays are active", (MARGIN + 210, first), &NOTE, HPos::Left)?;
    area.draw(&Circle::new((MARGIN + 490, first), 8, RUN.stroke_width(1)))?;
    text(area, "only for an EXR file", (MARGIN + 504, first), &NOTE, HPos::Left)?;
    let mut x = MARGIN + 4;
    let last = DOTS.len() - 1;
    for (i, &(least, radius)) in DOTS.iter().enumerate() {
        area.draw(&Circle::new((x, second), radius, DOT.filled()))?;
        let words = match DOTS.get(i + 1) {
            Some((next, _)) => format!("{least} to {}", next - 1),
            None => format!("{least} or more"),
        };
        text(area, &words, (x + 10, second), &NOTE, HPos::Left)?;
        x += if i < last { 70 } else { 90 };
    }
    let what = "names that the band at the dot's left uses of the band at the foot of its arrow";
    text(area, what, (x + 10, second), &NOTE, HPos::Left)
}
