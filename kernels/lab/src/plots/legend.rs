//! Legends: entries in rows, or groups of them with headings.

use super::draw::{MARGIN, RING, color, draw_mark, heading, line, ring, widest};
use super::font::{self, wrapped};
use super::frame::Frame;
use super::picture::{BLACK, Color, Dashes, LINE, Picture, Point, SIZE, Side, THIN};
use super::{Mark, Series, Stroke};
use crate::text::visible;

/// What a legend's entry shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Symbol {
    /// A line with a mark.
    Line(Stroke, Mark, bool),
    /// An area.
    Area,
    /// A line at a value.
    Place(Dashes),
    /// A mark, hollow or not, with a ring around it.
    Ring(Mark, bool),
}

/// A legend's entry.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) color: Color,
    pub(super) symbol: Symbol,
}

impl Entry {
    pub(super) fn mark(name: &str, color: Color, mark: Mark, is_hollow: bool) -> Self {
        Self { name: name.to_owned(), color, symbol: Symbol::Line(Stroke::None, mark, is_hollow) }
    }

    /// Room for its symbol.
    fn symbol_width(&self) -> f64 {
        match self.symbol {
            Symbol::Ring(..) => 2.0 * RING + 1.0,
            Symbol::Line(Stroke::None, ..) | Symbol::Place(_) => 10.0,
            Symbol::Line(..) => 30.0,
            Symbol::Area => 18.0,
        }
    }

    /// Its width in one line.
    fn width(&self) -> f64 {
        self.symbol_width() + Rows::GAP + font::width(&visible(&self.name), SIZE)
    }

    /// As a line at a place across, between two heights.
    pub(super) fn draw_along(&self, picture: &mut Picture, x: f64, [top, bottom]: [f64; 2]) {
        if let Symbol::Place(dashes) = self.symbol {
            picture.line(self.color, THIN, dashes, &[(x, top), (x, bottom)]);
        }
    }

    fn draw(&self, picture: &mut Picture, (x, y): Point) {
        let end = x + self.symbol_width();
        let middle = (x + end) / 2.0;
        match self.symbol {
            Symbol::Line(stroke, mark, is_hollow) => {
                line(picture, stroke, &[(x, y), (end, y)], self.color);
                draw_mark(picture, mark, is_hollow, (middle, y), self.color);
            }
            Symbol::Area => {
                picture.filled(self.color, 1.0, Frame { left: x, right: end, top: y - 5.0, bottom: y + 5.0 });
            }
            Symbol::Place(dashes) => {
                picture.line(self.color, THIN, dashes, &[(middle, y - 7.0), (middle, y + 7.0)]);
            }
            Symbol::Ring(mark, is_hollow) => {
                draw_mark(picture, mark, is_hollow, (middle, y), self.color);
                ring(picture, (middle, y));
            }
        }
    }
}

/// Entries of a legend that one means tells apart, such as colour.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// What they are; may be empty.
    pub(super) heading: String,
    pub(super) entries: Vec<Entry>,
}

/// One entry for each name.
pub(super) fn entries<'a>(series: impl Iterator<Item = &'a Series>) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for s in series.filter(|s| !s.name.is_empty()) {
        if !entries.iter().any(|entry| entry.name == s.name) {
            let symbol = Symbol::Line(s.stroke, s.mark.of(s.color), false);
            entries.push(Entry { name: s.name.clone(), color: color(s.color), symbol });
        }
    }
    entries
}

/// Lines at named values, told apart by their dashes, as legend entries.
pub(super) fn places(places: &[(f64, String)]) -> impl Iterator<Item = (f64, Entry)> {
    const DASHES: [Dashes; 4] = [&[6.0, 4.0], &[1.5, 2.5], &[7.0, 3.0, 1.5, 3.0], &[12.0, 4.0]];
    places.iter().zip(DASHES.into_iter().cycle()).map(|((value, name), dashes)| {
        (*value, Entry { name: name.clone(), color: BLACK, symbol: Symbol::Place(dashes) })
    })
}

/// The heading, on screens, and the legend, in rows; returns where they end.
pub(super) fn head(picture: &mut Picture, title: &str, entries: &[Entry]) -> f64 {
    let end = heading(picture, title);
    rows(picture, entries, end)
}

/// Entries in rows of the picture's width, from a height on; returns where they end.
pub(super) fn rows(picture: &mut Picture, entries: &[Entry], from: f64) -> f64 {
    let mut rows = Rows::new(picture, from);
    entries.iter().for_each(|entry| rows.add(picture, entry));
    rows.end()
}

/// The same for groups with headings. As many groups share a row as fit; one that does not fit into the rest of a row
/// begins the next one. The entries of groups that begin rows are aligned.
pub(super) fn groups(picture: &mut Picture, groups: &[Group], from: f64) -> f64 {
    let groups: Vec<(&Group, Vec<String>)> =
        groups.iter().filter(|group| !group.entries.is_empty()).map(|group| (group, group.title(picture))).collect();
    let column = groups.iter().map(|(_, title)| indent(title)).fold(0.0, f64::max);
    let mut rows = Rows::new(picture, from);
    for (group, title) in &groups {
        let wide = indent(title) + group.entries.iter().map(Entry::width).sum::<f64>();
        let is_first = rows.begin_group(wide + Rows::APART * (group.entries.len() as f64 - 1.0));
        rows.title(picture, title, if is_first { column } else { indent(title) });
        group.entries.iter().for_each(|entry| rows.add(picture, entry));
    }
    rows.end()
}

impl Group {
    /// The heading, in lines that leave most of the picture's width to the entries.
    fn title(&self, picture: &Picture) -> Vec<String> {
        const SHARE: f64 = 0.3;
        if self.heading.is_empty() {
            return Vec::new();
        }
        wrapped(&format!("{}:", self.heading), SIZE, SHARE * picture.width())
    }
}

/// Room for the heading of a group.
fn indent(title: &[String]) -> f64 {
    if title.is_empty() { 0.0 } else { widest(title) + Rows::GAP }
}

/// Where the next entry of a legend is drawn.
struct Rows {
    /// Where its rows begin, and the picture's width ends.
    left: f64,
    right: f64,
    /// The next entry's place.
    x: f64,
    y: f64,
    /// Where the entries of the row end.
    under: f64,
    /// Where everything ends.
    bottom: f64,
}

impl Rows {
    /// Between a symbol or a heading and what it belongs to.
    const GAP: f64 = 6.0;
    /// Between entries.
    const APART: f64 = 16.0;

    fn new(picture: &Picture, from: f64) -> Self {
        Self { left: MARGIN, right: picture.width() - MARGIN, x: MARGIN, y: from, under: from, bottom: from }
    }

    /// Begins a group of this width, in the next row if it does not fit into this one; returns whether a row begins
    /// with it.
    fn begin_group(&mut self, wide: f64) -> bool {
        if self.x > MARGIN && self.x + wide > self.right {
            (self.x, self.y) = (MARGIN, self.bottom);
        }
        self.x <= MARGIN
    }

    /// Writes a group's heading; its rows begin beside it.
    fn title(&mut self, picture: &mut Picture, title: &[String], indent: f64) {
        picture.lines(title, (self.x, self.y + LINE / 2.0), [Side::Start, Side::Middle]);
        self.bottom = self.bottom.max(self.y + LINE * title.len() as f64);
        self.left = self.x + indent;
        self.x = self.left;
    }

    fn add(&mut self, picture: &mut Picture, entry: &Entry) {
        let begin = entry.symbol_width() + Self::GAP;
        let name = wrapped(&entry.name, SIZE, self.right - self.left - begin);
        let wide = begin + widest(&name);
        if self.x > self.left && self.x + wide > self.right {
            (self.x, self.y) = (self.left, self.under);
        }
        entry.draw(picture, (self.x, self.y + LINE / 2.0));
        picture.lines(&name, (self.x + begin, self.y + LINE / 2.0), [Side::Start, Side::Middle]);
        self.x += wide + Self::APART;
        self.under = self.under.max(self.y + LINE * name.len() as f64);
        self.bottom = self.bottom.max(self.under);
    }

    /// Where the legend ends, with a little room below it.
    fn end(self) -> f64 {
        self.bottom + if self.x > MARGIN { 3.0 } else { 0.0 }
    }
}
