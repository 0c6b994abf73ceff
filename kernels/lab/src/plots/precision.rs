//! The work–precision diagram: time against wrong rays, both logarithmic. Choices of which no ray was wrong have a strip
//! of their own below, one line each, since 0 has no place on a logarithmic axis and "no wrong ray seen" is a bound, not
//! a 0.

mod layout;

use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{BLACK, Color as _, RGBColor, ShapeStyle, WHITE};

use super::Shape;
use super::axis::Axis;
use super::draw::{Drawn, Frame, GRID, PALETTE, dashes, text_at};
use super::labels::Place;
use super::picture::{Area, Picture, Point};
use crate::Error;
use layout::{Layout, Mark, WIDTH};

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
    pub shape: Shape,
    /// Whether only the mark's outline is drawn.
    pub is_hollow: bool,
    /// Whether nothing is both faster and less often wrong.
    pub is_front: bool,
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
    /// Names of colours, shapes and fillings.
    pub legend: Vec<(String, Option<usize>, Shape, bool)>,
    /// Start of arrows to every choice; and a line there.
    pub from: Option<f64>,
    /// The choices, fastest first.
    pub choices: Vec<Choice>,
}

/// Height below the frame: labels of the horizontal axis, and its name.
const FOOT: i32 = 35;

impl Precision {
    /// The drawn diagram; `None` without choices.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn picture(&self) -> Result<Option<Picture>, Error> {
        if self.choices.is_empty() {
            return Ok(None);
        }
        let layout = Layout::new(self);
        let size = (WIDTH as u32, (layout.frame.bottom + FOOT) as u32);
        Picture::drawn(size, |area| self.draw(area, &layout)).map(Some)
    }

    fn draw(&self, area: &Area<'_>, layout: &Layout<'_>) -> Drawn {
        self.axes(area, layout)?;
        // What f32 cannot decide: pale, as it is no error.
        for (choice, bar) in self.choices.iter().filter_map(|c| Some((c, layout.bar(c)?))) {
            let style = PALETTE[choice.color % PALETTE.len()].mix(0.25).filled();
            area.draw(&Rectangle::new([(bar.left, bar.top), (bar.right, bar.bottom)], style))?;
        }
        dashes(area, &layout.front(), BLACK.mix(0.6).stroke_width(1))?;
        layout.marks.iter().try_for_each(|mark| self.choice(area, layout, mark))?;
        for leader in layout.labels.iter().filter_map(|place| place.leader) {
            area.draw(&PathElement::new(leader, BLACK.mix(0.5).stroke_width(1)))?;
        }
        for (mark, place) in layout.marks.iter().zip(&layout.labels) {
            label(area, &mark.choice.label, place, mark.at)?;
        }
        let bound = self.at_most.map_or(String::new(), |most| format!(": at most {} per million (95%)", round(most)));
        let title = format!("no wrong ray seen{bound}");
        let (place, at) = layout.title(&title);
        label(area, &title, &place, at)
    }

    fn axes(&self, area: &Area<'_>, layout: &Layout<'_>) -> Drawn {
        let Frame { left, right, top, bottom } = layout.frame;
        text_at(area, &self.title, (8, 12), 15, (HPos::Left, VPos::Center))?;
        legend(area, &self.legend, 16 + 7 * self.title.chars().count() as i32)?;
        for (x, text) in layout.columns() {
            area.draw(&PathElement::new([(x, top), (x, bottom)], GRID))?;
            text_at(area, &text, (x, bottom + 5), 12, (HPos::Center, VPos::Top))?;
        }
        text_at(area, &self.x.label, ((left + right) / 2, bottom + 19), 13, (HPos::Center, VPos::Top))?;
        if layout.has_log {
            for (y, text) in layout.rows() {
                area.draw(&PathElement::new([(left, y), (right, y)], GRID))?;
                text_at(area, &text, (left - 6, y), 13, (HPos::Right, VPos::Center))?;
            }
            text_at(area, &self.y.label, (left, top - 4), 12, (HPos::Left, VPos::Bottom))?;
            let y = layout.log_end();
            area.draw(&PathElement::new([(left, y), (right, y)], BLACK.stroke_width(1)))?;
        }
        area.draw(&Rectangle::new([(left, top), (right, bottom)], BLACK.stroke_width(1)))?;
        Ok(())
    }

    /// Mark, intervals and arrow of a choice.
    fn choice(&self, area: &Area<'_>, layout: &Layout<'_>, &Mark { choice: c, at, .. }: &Mark<'_>) -> Drawn {
        let color = PALETTE[c.color % PALETTE.len()];
        let thin = color.stroke_width(1);
        if let Some(ends) = c.x_ends {
            let [low, high] = [ends.0, ends.1].map(|end| layout.across(end));
            area.draw(&PathElement::new([(low, at.1), (high, at.1)], thin))?;
            for x in [low, high] {
                area.draw(&PathElement::new([(x, at.1 - 3), (x, at.1 + 3)], thin))?;
            }
        }
        if let (Some((low, high)), true) = (c.wrong_ends, c.wrong > 0.0) {
            area.draw(&PathElement::new([(at.0, layout.up(low)), (at.0, layout.up(high))], thin))?;
        }
        if let Some(from) = self.from {
            arrow(area, (layout.across(from), at.1), at, color)?;
        }
        mark(area, c.shape, c.is_hollow, at, color)
    }
}

/// Text in its place, on a background that interrupts lines behind it, at the side where its mark is.
fn label(area: &Area<'_>, text: &str, &Place { frame, .. }: &Place, at: Point) -> Drawn {
    let Frame { left, right, top, bottom } = frame;
    area.draw(&Rectangle::new([(left, top), (right, bottom)], WHITE.filled()))?;
    let (x, side) = match at.0 {
        x if right <= x => (right, HPos::Right),
        x if left >= x => (left, HPos::Left),
        _ => ((left + right) / 2, HPos::Center),
    };
    text_at(area, text, (x, (top + bottom) / 2), 12, (side, VPos::Center))
}

/// A number of at most two digits that matter.
fn round(value: f64) -> String {
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    rounded.to_string()
}

fn arrow(area: &Area<'_>, from: (i32, i32), to: (i32, i32), color: RGBColor) -> Drawn {
    let way = (to.0 - from.0).signum();
    // Between marks: from the line to beside the mark.
    let end = to.0 - 7 * way;
    if (end - from.0) * way <= 2 {
        return Ok(());
    }
    area.draw(&PathElement::new([from, (end, to.1)], color.mix(0.6).stroke_width(1)))?;
    let head = [(end, to.1), (end - 5 * way, to.1 - 4), (end - 5 * way, to.1 + 4)];
    area.draw(&Polygon::new(head, color.filled()))?;
    Ok(())
}

fn legend(area: &Area<'_>, entries: &[(String, Option<usize>, Shape, bool)], from: i32) -> Drawn {
    let mut x = from;
    for (name, color, shape, is_hollow) in entries {
        let color = color.map_or(RGBColor(0, 0, 0), |c| PALETTE[c % PALETTE.len()]);
        mark(area, *shape, *is_hollow, (x, 12), color)?;
        text_at(area, name, (x + 9, 12), 12, (HPos::Left, VPos::Center))?;
        x += 22 + 6 * name.chars().count() as i32;
    }
    Ok(())
}

fn mark(area: &Area<'_>, shape: Shape, is_hollow: bool, (x, y): (i32, i32), color: RGBColor) -> Drawn {
    let style: ShapeStyle = if is_hollow { color.stroke_width(2) } else { color.filled() };
    let polygon = |points: Vec<(i32, i32)>| match is_hollow {
        true => area
            .draw(&PathElement::new(points.iter().copied().chain(points.first().copied()).collect::<Vec<_>>(), style)),
        false => area.draw(&Polygon::new(points.clone(), style)),
    };
    match shape {
        Shape::Disc => area.draw(&Circle::new((x, y), 4, style))?,
        Shape::Square => area.draw(&Rectangle::new([(x - 4, y - 4), (x + 4, y + 4)], style))?,
        Shape::Up => polygon(vec![(x, y - 5), (x + 5, y + 4), (x - 5, y + 4)])?,
        Shape::Down => polygon(vec![(x, y + 5), (x + 5, y - 4), (x - 5, y - 4)])?,
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::Scale;
    use crate::plots::picture::{Element, Form};

    fn choice(x: f64, wrong: f64) -> Choice {
        Choice {
            label: format!("<{x}>"),
            x,
            x_ends: Some((0.9 * x, 1.1 * x)),
            wrong,
            wrong_ends: (wrong > 0.0).then_some((0.5 * wrong, 2.0 * wrong)),
            undecided: 3.0,
            color: 0,
            shape: Shape::Disc,
            is_hollow: false,
            is_front: true,
        }
    }

    fn of(choices: Vec<Choice>) -> Precision {
        Precision {
            title: "time & wrong".into(),
            x: Axis::new("ns per ray", Scale::Log),
            y: Axis::new("wrong per million", Scale::Log),
            at_most: Some(81.26),
            legend: vec![("grid".into(), Some(0), Shape::Disc, false)],
            from: None,
            choices,
        }
    }

    fn drawn(diagram: &Precision) -> Picture {
        diagram.picture().expect("no error").expect("a diagram")
    }

    #[test]
    fn none_wrong_has_a_line_of_its_own_and_every_choice_a_name() {
        assert_eq!(of(Vec::new()).picture().expect("no error"), None);
        let svg = |diagram: &Precision| drawn(diagram).svg().expect("no error");
        let choices = of(vec![choice(100.0, 0.0), choice(50.0, 30.0), choice(200.0, 0.0)]);
        let text = svg(&choices);
        assert!(text.contains("&lt;100&gt;") && text.contains("&lt;50&gt;") && text.contains("at most 81 per million"));
        assert!(text.contains("wrong per million"));
        let first = text.lines().nth(1).unwrap_or_default();
        assert!(
            first.starts_with("<rect x=\"0\" y=\"0\" width=\"620\"") && first.contains("fill=\"#FFFFFF\""),
            "{first}"
        );
        // Three choices and the legend's mark.
        assert_eq!(text.matches("<circle").count(), 4);
        let arrows = Precision { from: Some(1.0), ..of(vec![choice(2.0, 0.0)]) };
        assert!(svg(&arrows).contains("<polygon"));
    }

    /// Backgrounds of labels: white rectangles.
    fn backgrounds(picture: &Picture) -> Vec<Frame> {
        let frame = |element: &Element| match element.form {
            Form::Rectangle { corners: [(left, top), (right, bottom)], is_filled: true }
                if element.color == [255; 3] =>
            {
                Some(Frame { left, right, top, bottom })
            }
            _ => None,
        };
        picture.elements.iter().filter_map(frame).collect()
    }

    #[test]
    fn names_of_choices_at_one_place_lie_apart_and_within_the_frame() {
        let long = |x: f64, wrong: f64| Choice { label: format!("a rather long name, {x}"), ..choice(x, wrong) };
        // Intervals from one side to the other leave no room beside the mark.
        let wide = |x: f64, wrong: f64| Choice { x_ends: Some((20.0, 900.0)), ..long(x, wrong) };
        let all = vec![long(100.0, 1e6), long(100.5, 1e6), wide(101.0, 9e5), wide(880.0, 1e6), wide(50.0, 0.0)];
        let diagram = of(all);
        let (picture, layout) = (drawn(&diagram), Layout::new(&diagram));
        let labels = backgrounds(&picture);
        assert_eq!(labels.len(), 6, "five choices and the strip's title");
        for (i, &label) in labels.iter().enumerate() {
            assert!(layout.frame.left < label.left && label.right < layout.frame.right, "{label:?}");
            assert!(!labels[..i].iter().any(|other| other.meets(label)), "{labels:?}");
            assert!(!layout.marks.iter().any(|mark| Frame::around(mark.at, 5).meets(label)), "{labels:?}");
        }
        let texts = |wanted: &str| {
            let is = |element: &&Element| matches!(&element.form, Form::Text { text, .. } if text == wanted);
            picture.elements.iter().filter(is).count()
        };
        assert_eq!((texts("1M"), texts("1e6"), texts("2M")), (1, 0, 0), "no more than all rays are wrong");
    }
}
