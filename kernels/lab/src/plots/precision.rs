//! The work–precision diagram: time against wrong rays, both logarithmic. Choices of which no ray was wrong have a strip
//! of their own below, one line each, since 0 has no place on a logarithmic axis and "none seen" is a bound, not a 0.

use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{BLACK, Color as _, RGBColor, ShapeStyle};

use super::axis::Axis;
use super::draw::{Drawn, Frame, GRID, PALETTE, dashes, text_at};
use super::picture::{Area, Picture};
use super::{Scale, Shape};
use crate::Error;

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
    /// The largest share of wrong rays, per million, that "none seen" leaves possible.
    pub at_most: Option<f64>,
    /// Names of colours, shapes and fillings.
    pub legend: Vec<(String, Option<usize>, Shape, bool)>,
    /// Start of arrows to every choice; and a line there.
    pub from: Option<f64>,
    /// The choices, fastest first.
    pub choices: Vec<Choice>,
}

const WIDTH: i32 = 620;
const LEFT: i32 = 64;
const RIGHT: i32 = 604;
const TOP: i32 = 44;
/// Height of a line of the strip.
const LANE: i32 = 13;
/// Height of the logarithmic part.
const LOG: i32 = 116;
/// Height of the strip's own title.
const HEAD: i32 = 18;

impl Precision {
    /// The drawn diagram; `None` without choices.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn picture(&self) -> Result<Option<Picture>, Error> {
        if self.choices.is_empty() {
            return Ok(None);
        }
        let (none, some): (Vec<&Choice>, Vec<&Choice>) = self.choices.iter().partition(|c| c.wrong <= 0.0);
        let ends = |c: &Choice| c.x_ends.map_or([c.x; 2], |(low, high)| [low, high]);
        let x = self.x.over(self.choices.iter().flat_map(|c| [c.x].into_iter().chain(ends(c))).chain(self.from));
        let y = Axis::new("", Scale::Log).over(
            some.iter()
                .flat_map(|c| [Some(c.wrong), c.wrong_ends.map(|e| e.0), c.wrong_ends.map(|e| e.1)])
                .flatten()
                .chain(self.choices.iter().map(|c| c.undecided))
                .filter(|&v| v > 0.0)
                // Room for more than one label where all are alike.
                .flat_map(|v| [v / 2.0, v * 2.0]),
        );
        let has_log = !some.is_empty() || self.choices.iter().any(|c| c.undecided > 0.0);
        let log_end = if has_log { TOP + LOG } else { TOP };
        let strip = log_end + HEAD;
        let bottom = strip + LANE * none.len().max(1) as i32 + 4;
        let frame = Frame { left: LEFT, right: RIGHT, top: TOP, bottom };
        let across = |v: f64| LEFT + (f64::from(RIGHT - LEFT) * x.part(v)).round() as i32;
        let up = |v: f64| log_end - 4 - (f64::from(log_end - TOP - 8) * y.part(v)).round() as i32;
        Picture::drawn((WIDTH as u32, (bottom + 40) as u32), |area| {
            text_at(area, &self.title, (8, 12), 15, (HPos::Left, VPos::Center))?;
            legend(area, &self.legend, 16 + 7 * self.title.chars().count() as i32)?;
            for (value, text) in x.ticks() {
                area.draw(&PathElement::new([(across(value), TOP), (across(value), bottom)], GRID))?;
                text_at(area, &text, (across(value), bottom + 5), 12, (HPos::Center, VPos::Top))?;
            }
            text_at(area, &self.x.label, ((LEFT + RIGHT) / 2, bottom + 21), 13, (HPos::Center, VPos::Top))?;
            if has_log {
                for (value, text) in y.ticks() {
                    area.draw(&PathElement::new([(LEFT, up(value)), (RIGHT, up(value))], GRID))?;
                    text_at(area, &text, (LEFT - 6, up(value)), 13, (HPos::Right, VPos::Center))?;
                }
                let of = "wrong rays per million";
                text_at(area, of, (LEFT, TOP - 4), 12, (HPos::Left, VPos::Bottom))?;
                area.draw(&PathElement::new([(LEFT, log_end), (RIGHT, log_end)], BLACK.stroke_width(1)))?;
            }
            let bound =
                self.at_most.map_or(String::new(), |most| format!(": at most {} per million (95%)", round(most)));
            text_at(
                area,
                &format!("none seen wrong{bound}"),
                (LEFT + 4, log_end + 10),
                12,
                (HPos::Left, VPos::Center),
            )?;
            outline(area, frame)?;
            // What f32 cannot decide: pale, as it is no error.
            for c in self.choices.iter().filter(|c| has_log && c.undecided > 0.0) {
                let style = PALETTE[c.color % PALETTE.len()].mix(0.25).filled();
                area.draw(&Rectangle::new(
                    [(across(c.x) - 4, up(c.undecided)), (across(c.x) + 4, log_end - 1)],
                    style,
                ))?;
            }
            let place = |c: &Choice| {
                let lane = none.iter().position(|n| std::ptr::eq(*n, c)).map(|i| strip + LANE * i as i32 + LANE / 2);
                (across(c.x), lane.unwrap_or_else(|| up(c.wrong)))
            };
            self.front(area, &place)?;
            let mut taken = Taken::default();
            self.choices.iter().for_each(|c| taken.add_mark(place(c)));
            for c in some.iter().chain(&none) {
                self.draw(area, c, place(c), &across, &up)?;
            }
            for c in some.iter().chain(&none) {
                let width = 6 * c.label.chars().count() as i32;
                let (x, y, side) = taken.place(place(c), ends(c).map(across), width, c.wrong <= 0.0);
                text_at(area, &c.label, (x, y), 12, (side, VPos::Center))?;
            }
            Ok(())
        })
        .map(Some)
    }

    /// The line along choices that nothing beats in both.
    fn front(&self, area: &Area<'_>, place: &impl Fn(&Choice) -> (i32, i32)) -> Drawn {
        let mut at: Vec<(i32, i32)> = self.choices.iter().filter(|c| c.is_front).map(place).collect();
        at.sort_unstable();
        let corners: Vec<(i32, i32)> =
            at.windows(2).flat_map(|p| [p[0], (p[1].0, p[0].1)]).chain(at.last().copied()).collect();
        if at.len() > 1 { dashes(area, &corners, BLACK.mix(0.6).stroke_width(1)) } else { Ok(()) }
    }

    fn draw(
        &self,
        area: &Area<'_>,
        c: &Choice,
        at: (i32, i32),
        across: &impl Fn(f64) -> i32,
        up: &impl Fn(f64) -> i32,
    ) -> Drawn {
        let color = PALETTE[c.color % PALETTE.len()];
        let thin = color.stroke_width(1);
        if let Some((low, high)) = c.x_ends {
            area.draw(&PathElement::new([(across(low), at.1), (across(high), at.1)], thin))?;
            for x in [across(low), across(high)] {
                area.draw(&PathElement::new([(x, at.1 - 3), (x, at.1 + 3)], thin))?;
            }
        }
        if let (Some((low, high)), true) = (c.wrong_ends, c.wrong > 0.0) {
            area.draw(&PathElement::new([(at.0, up(low)), (at.0, up(high))], thin))?;
        }
        if let Some(from) = self.from {
            arrow(area, (across(from), at.1), at, color)?;
        }
        mark(area, c.shape, c.is_hollow, at, color)
    }
}

/// A number of at most two digits that matter.
fn round(value: f64) -> String {
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    rounded.to_string()
}

fn outline(area: &Area<'_>, frame: Frame) -> Drawn {
    let corners = [(frame.left, frame.top), (frame.right, frame.bottom)];
    area.draw(&Rectangle::new(corners, BLACK.stroke_width(1)))?;
    Ok(())
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

/// Boxes that labels and marks cover: left, right and height of the middle.
#[derive(Default)]
struct Taken(Vec<(i32, i32, i32)>);

impl Taken {
    fn add_mark(&mut self, (x, y): (i32, i32)) {
        self.0.push((x - 5, x + 5, y));
    }

    /// Beside the mark at `at`, whose interval ends at `ends`, or else a little above or below.
    fn place(&mut self, at: (i32, i32), ends: [i32; 2], width: i32, has_lane: bool) -> (i32, i32, HPos) {
        let right = ends[1].max(at.0 + 5) + 5;
        let left = ends[0].min(at.0 - 5) - 5;
        let spans = [(right, right + width, HPos::Left), (left - width, left, HPos::Right)];
        let offsets: &[i32] = if has_lane { &[0] } else { &[0, -11, 11, -22, 22, -33, 33, -44, 44] };
        let is_free = |l: i32, r: i32, y: i32| {
            l >= LEFT && r <= RIGHT + 8 && self.0.iter().all(|t| r < t.0 || l > t.1 || (t.2 - y).abs() >= 10)
        };
        let mut all = offsets.iter().flat_map(|o| spans.iter().map(move |s| (*s, at.1 + o)));
        let free = all.find(|((l, r, _), y)| *y > TOP + 4 && is_free(*l, *r, *y));
        let ((l, r, side), y) = free.unwrap_or((spans[usize::from(at.0 > (LEFT + RIGHT) / 2)], at.1));
        self.0.push((l, r, y));
        (if matches!(side, HPos::Left) { l } else { r }, y, side)
    }
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

    #[test]
    fn none_wrong_has_a_line_of_its_own_and_every_choice_a_name() {
        let of = |choices: Vec<Choice>| Precision {
            title: "time & wrong".into(),
            x: Axis::new("ns a ray", Scale::Log),
            at_most: Some(81.26),
            legend: vec![("grid".into(), Some(0), Shape::Disc, false)],
            from: None,
            choices,
        };
        assert_eq!(of(Vec::new()).picture().expect("no error"), None);
        let svg = |diagram: &Precision| {
            let picture = diagram.picture().expect("no error").expect("a diagram");
            picture.svg().expect("no error")
        };
        let choices = of(vec![choice(100.0, 0.0), choice(50.0, 30.0), choice(200.0, 0.0)]);
        let text = svg(&choices);
        assert!(text.contains("&lt;100&gt;") && text.contains("&lt;50&gt;") && text.contains("at most 81 per million"));
        // Three choices and the legend's mark.
        assert_eq!(text.matches("<circle").count(), 4);
        let arrows = Precision { from: Some(1.0), ..of(vec![choice(2.0, 0.0)]) };
        assert!(svg(&arrows).contains("<polygon"));
    }
}
