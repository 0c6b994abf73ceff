//! The work–precision diagram: time against wrong rays, both logarithmic. Choices of which no ray was wrong have a strip
//! of their own below, one line each, since 0 has no place on a logarithmic axis and "no wrong ray seen" is a bound, not
//! a 0.

mod layout;
#[cfg(test)]
mod tests;

use super::axis::Axis;
use super::draw::{HALF_MARK, above, below, color, columns, draw_mark, heading, ring, upright};
use super::frame::Frame;
use super::legend::{Entry, Group, Symbol, groups, rows};
use super::picture::{BLACK, Color, Form, Picture, Point, Side, THIN, WHITE};
use super::{Draw, Format, Mark};
use crate::human::field;
use layout::{Label, Layout};

/// Width on a screen.
const WIDTH: f64 = 620.0;

/// A choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Its name beside the mark.
    pub label: String,
    /// Time, or ratio of times.
    pub x: f64,
    /// Its interval.
    pub x_ends: Option<(f64, f64)>,
    /// Wrong rays per million.
    pub wrong: f64,
    /// Its interval.
    pub wrong_ends: Option<(f64, f64)>,
    /// Undecided rays per million.
    pub undecided: f64,
    /// Index into the palette.
    pub color: usize,
    /// The mark.
    pub shape: Mark,
    /// Whether only the mark's outline is drawn.
    pub is_hollow: bool,
    /// Whether nothing is both faster and less often wrong.
    pub is_front: bool,
    /// Whether it is the one to use: it has a ring.
    pub is_recommended: bool,
}

/// What one means of telling choices apart stands for, such as their colours.
#[derive(Clone, Debug)]
pub struct Legend {
    /// Its heading.
    pub heading: String,
    /// Its entries; without any, the heading is left out, too.
    pub signs: Vec<Sign>,
}

/// What a colour, a shape or a filling stands for.
#[derive(Clone, Debug)]
pub struct Sign {
    /// Its meaning.
    pub name: String,
    /// Index into the palette; `None` where the colour has no meaning.
    pub color: Option<usize>,
    /// The mark.
    pub shape: Mark,
    /// Whether only its outline is drawn.
    pub is_hollow: bool,
}

/// The diagram.
#[derive(Clone, Debug)]
pub struct Precision {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis, logarithmic: wrong rays per million of which rays.
    pub y: Axis,
    /// The largest share of wrong rays, per million, that is possible where none was seen.
    pub at_most: Option<f64>,
    /// Names of colours, shapes and fillings. That of the ring follows.
    pub legend: Vec<Legend>,
    /// Start of arrows to every choice; and a line there.
    pub from: Option<f64>,
    /// The choices, fastest first.
    pub choices: Vec<Choice>,
}

impl Draw for Precision {
    fn title(&self) -> &str {
        &self.title
    }

    fn picture(&self, format: Format) -> Option<Picture> {
        if self.choices.is_empty() {
            return None;
        }
        let mut picture = Picture::new(format, WIDTH);
        let mut top = heading(&mut picture, &self.title);
        top = groups(&mut picture, &self.groups(), top);
        let has_log = self.choices.iter().any(|choice| choice.wrong > 0.0 || choice.undecided > 0.0);
        top = above(&mut picture, if has_log { &self.y.label } else { "" }, top);
        let layout = Layout::new(self, picture.width(), top);
        let columns = columns(&picture, layout.frame, layout.x());
        upright(&mut picture, layout.frame, layout.x(), &columns);
        if has_log {
            layout.beside(&mut picture);
        }
        self.draw(&mut picture, &layout);
        let end = below(&mut picture, layout.frame, layout.x(), &columns, &self.x.label);
        picture.size.1 = rows(&mut picture, &layout.key(), end);
        Some(picture)
    }
}

impl Precision {
    /// The legend, with the recommended choice's mark as it is drawn.
    fn groups(&self) -> Vec<Group> {
        let entry = |sign: &Sign| Entry::mark(&sign.name, sign.color.map_or(BLACK, color), sign.shape, sign.is_hollow);
        let group = |legend: &Legend| Group {
            heading: legend.heading.clone(),
            entries: legend.signs.iter().map(entry).collect(),
        };
        let recommended = self.choices.iter().find(|choice| choice.is_recommended).map(|choice| Entry {
            name: "recommended".into(),
            color: color(choice.color),
            symbol: Symbol::Ring(choice.shape, choice.is_hollow),
        });
        let last = Group { heading: String::new(), entries: recommended.into_iter().collect() };
        self.legend.iter().map(group).chain([last]).collect()
    }

    /// The title of the strip.
    fn strip(&self) -> String {
        let bound = self.at_most.map_or(String::new(), |most| {
            format!(": at most {} per million (95%)", field("most_wrong_per_million", &most.to_string()))
        });
        format!("no wrong ray seen{bound}")
    }

    fn draw(&self, picture: &mut Picture, layout: &Layout<'_>) {
        // What f32 cannot decide: pale, as it is no error.
        for (choice, bar) in self.choices.iter().filter_map(|c| Some((c, layout.bar(c)?))) {
            picture.filled(color(choice.color), 0.25, bar);
        }
        let Frame { top, bottom, .. } = layout.frame;
        if let Some(x) = self.from.map(|from| layout.across(from)) {
            picture.line(BLACK, THIN, &[], &[(x, top), (x, bottom)]);
        }
        picture.line(BLACK, THIN, &[7.0, 4.0], &layout.front());
        layout.marks.iter().for_each(|mark| self.choice(picture, layout, mark));
        for leader in layout.labels.iter().filter_map(|label| label.place.leader) {
            picture.add(BLACK, 0.5, Form::Line { points: leader.to_vec(), width: THIN, dashes: &[] });
        }
        layout.labels.iter().for_each(|label| write(picture, label));
        picture.border(layout.frame);
    }

    /// Mark, intervals and arrow of a choice.
    fn choice(
        &self,
        picture: &mut Picture,
        layout: &Layout<'_>,
        &layout::Mark { choice: c, at, .. }: &layout::Mark<'_>,
    ) {
        let color = color(c.color);
        if let Some(ends) = c.x_ends {
            let [low, high] = [ends.0, ends.1].map(|end| layout.across(end));
            picture.thin(color, (low, at.1), (high, at.1));
            [low, high].iter().for_each(|&x| picture.thin(color, (x, at.1 - 3.0), (x, at.1 + 3.0)));
        }
        if let (Some((low, high)), true) = (c.wrong_ends, c.wrong > 0.0) {
            picture.thin(color, (at.0, layout.up(low)), (at.0, layout.up(high)));
        }
        if let Some(from) = self.from {
            arrow(picture, (layout.across(from), at.1), at, color);
        }
        draw_mark(picture, c.shape, c.is_hollow, at, color);
        if c.is_recommended {
            ring(picture, at);
        }
    }
}

/// Text in its place, on a background that interrupts lines behind it.
fn write(picture: &mut Picture, label: &Label) {
    let frame = label.place.frame;
    picture.filled(WHITE, 1.0, frame);
    picture.lines(&label.lines, (label.left(), frame.top + layout::FIRST), [Side::Start, Side::Middle]);
}

/// Between marks: from the line to beside the mark.
fn arrow(picture: &mut Picture, from: Point, to: Point, color: Color) {
    let sign = (to.0 - from.0).signum();
    let end = to.0 - (HALF_MARK + 2.0) * sign;
    if (end - from.0) * sign <= 2.0 {
        return;
    }
    picture.add(color, 0.6, Form::Line { points: vec![from, (end, to.1)], width: THIN, dashes: &[] });
    let points = vec![(end, to.1), (end - 5.0 * sign, to.1 - 4.0), (end - 5.0 * sign, to.1 + 4.0)];
    picture.add(color, 1.0, Form::Polygon { points, outline: None });
}
