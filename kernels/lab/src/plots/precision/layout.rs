//! Where the parts of the diagram lie.

use super::{Choice, Precision};
use crate::plots::axis::Ranged;
use crate::plots::draw::Frame;
use crate::plots::labels::{HALF, Obstacles, Place, Wanted, places, width_of};
use crate::plots::picture::Point;

/// Width of the picture.
pub(super) const WIDTH: i32 = 620;
const LEFT: i32 = 64;
const RIGHT: i32 = 604;
const TOP: i32 = 40;
/// Height of the strip's own title.
const HEAD: i32 = 16;
/// Height of a line of the strip.
const LANE: i32 = 12;
/// Height of the logarithmic part: without marks, and for each of the first so many.
const LOG: [i32; 3] = [72, 8, 12];
/// Room in it for labels, above and below all marks.
const ROOM: [i32; 2] = [22, 14];
/// Between a label and what is beside it.
const GAP: i32 = 4;
/// Least distance of labels of an axis.
const APART: i32 = 11;

/// All rays, per million.
const ALL: f64 = 1e6;

/// Values to pixels.
#[derive(Clone, Copy)]
struct Scales {
    x: Ranged,
    y: Ranged,
    /// Where the logarithmic part ends.
    log_end: i32,
}

impl Scales {
    fn across(&self, value: f64) -> i32 {
        LEFT + (f64::from(RIGHT - LEFT) * self.x.part(value)).round() as i32
    }

    fn up(&self, value: f64) -> i32 {
        let [above, below] = ROOM;
        let height = f64::from(self.log_end - TOP - above - below);
        self.log_end - below - (height * self.y.part(value)).round() as i32
    }

    /// A choice with its mark at this height.
    fn mark<'a>(&self, from: Option<f64>, choice: &'a Choice, y: i32) -> Mark<'a> {
        let at = (self.across(choice.x), y);
        let ends = choice.x_ends.into_iter().flat_map(|(low, high)| [low, high]).chain(from).map(|v| self.across(v));
        let reach = ends.fold([at.0 - HALF, at.0 + HALF], |[low, high], x| [low.min(x), high.max(x)]);
        Mark { choice, at, reach }
    }
}

/// A choice in the diagram.
#[derive(Clone, Copy)]
pub(super) struct Mark<'a> {
    pub(super) choice: &'a Choice,
    pub(super) at: Point,
    /// From where to where its mark, interval and arrow lie.
    reach: [i32; 2],
}

/// A label's place on a line.
fn on_line(left: i32, width: i32, y: i32) -> Place {
    let frame = Frame { left, right: left + width, top: y - HALF, bottom: y + HALF };
    Place { frame, leader: None }
}

impl Mark<'_> {
    /// The label's place on the mark's own line, on the right or on the left, if there is room.
    fn beside(&self) -> Option<Place> {
        let width = width_of(&self.choice.label);
        let [low, high] = self.reach;
        let is_inside = |left: &i32| *left > LEFT && left + width < RIGHT;
        let left = [high + GAP, low - GAP - width].into_iter().find(is_inside)?;
        Some(on_line(left, width, self.at.1))
    }

    /// Its place on a line above.
    fn above(&self) -> Place {
        let width = width_of(&self.choice.label);
        let left = (self.at.0 - width / 2).min(RIGHT - GAP - width).max(LEFT + GAP);
        on_line(left, width, self.at.1 - LANE)
    }
}

/// Where everything lies.
pub(super) struct Layout<'a> {
    scales: Scales,
    pub(super) has_log: bool,
    /// Outline of both parts.
    pub(super) frame: Frame,
    /// All choices: first those of which a ray is wrong.
    pub(super) marks: Vec<Mark<'a>>,
    /// Their labels, in the same order.
    pub(super) labels: Vec<Place>,
}

impl<'a> Layout<'a> {
    pub(super) fn new(of: &'a Precision) -> Self {
        let (none, some): (Vec<&Choice>, Vec<&Choice>) = of.choices.iter().partition(|c| c.wrong <= 0.0);
        let with_ends = |value: f64, ends: Option<(f64, f64)>| {
            std::iter::once(value).chain(ends.into_iter().flat_map(|(low, high)| [low, high]))
        };
        let x = of.x.over(of.choices.iter().flat_map(|c| with_ends(c.x, c.x_ends)).chain(of.from));
        let wrong = some.iter().flat_map(|c| with_ends(c.wrong, c.wrong_ends));
        let shown: Vec<f64> = wrong.chain(of.choices.iter().map(|c| c.undecided)).filter(|&v| v > 0.0).collect();
        // So wide that there is more than one label where all are alike.
        let y = of.y.over(shown.iter().flat_map(|v| [v / 1.4, v * 1.4]).map(|v| v.min(ALL)));
        let has_log = !shown.is_empty();
        let [height, of_each, most] = LOG;
        let log_end = if has_log { TOP + height + of_each * most.min(some.len() as i32) } else { TOP };
        let scales = Scales { x, y, log_end };
        let marks: Vec<Mark<'a>> = some.iter().map(|&c| scales.mark(of.from, c, scales.up(c.wrong))).collect();
        let frame = Frame { left: LEFT, right: RIGHT, top: TOP, bottom: log_end };
        let mut layout = Self { scales, has_log, frame, marks, labels: Vec::new() };
        let mut top = log_end + HEAD;
        let mut labels = Vec::new();
        for &choice in &none {
            let mut mark = scales.mark(of.from, choice, top + LANE / 2);
            top += LANE;
            labels.push(mark.beside().unwrap_or_else(|| {
                mark.at.1 += LANE;
                top += LANE;
                mark.above()
            }));
            layout.marks.push(mark);
        }
        // A line's height if there is none, and a little room.
        layout.frame.bottom = top + 3 + if none.is_empty() { LANE } else { 0 };
        layout.labels = layout.labels_above(some.len());
        layout.labels.extend(labels);
        layout
    }

    /// Places of the labels of the first marks, those in the logarithmic part.
    fn labels_above(&self, count: usize) -> Vec<Place> {
        let marks = &self.marks[..count];
        let interval = |mark: &Mark<'_>| Some([self.up(mark.choice.wrong_ends?.0), self.up(mark.choice.wrong_ends?.1)]);
        let mut obstacles = Obstacles::default();
        for mark in marks {
            let (x, y) = mark.at;
            obstacles.hard.extend([Frame::around(mark.at, HALF), Frame::along(mark.reach.map(|x| (x, y)), 3)]);
            obstacles.hard.extend(interval(mark).map(|ends| Frame::along(ends.map(|y| (x, y)), 2)));
        }
        obstacles.soft.extend(self.marks.iter().filter_map(|mark| self.bar(mark.choice)));
        obstacles.soft.extend(self.dashed());
        let wanted = |mark: &Mark<'_>| Wanted { at: mark.at, width: width_of(&mark.choice.label) };
        let wanted: Vec<Wanted> = marks.iter().map(wanted).collect();
        places(Frame { bottom: self.scales.log_end, ..self.frame }, &wanted, &obstacles)
    }

    pub(super) fn across(&self, value: f64) -> i32 {
        self.scales.across(value)
    }

    pub(super) fn up(&self, value: f64) -> i32 {
        self.scales.up(value)
    }

    /// Where the logarithmic part ends.
    pub(super) fn log_end(&self) -> i32 {
        self.scales.log_end
    }

    /// Labels of the horizontal axis.
    pub(super) fn columns(&self) -> Vec<(i32, String)> {
        self.scales.x.ticks().into_iter().map(|(value, text)| (self.across(value), text)).collect()
    }

    /// Labels of the vertical axis: powers of ten, or some of them, where all would overlap.
    pub(super) fn rows(&self) -> Vec<(i32, String)> {
        let ticks = self.scales.y.ticks();
        let is_power = |(value, _): &&(f64, String)| (value.log10() - value.log10().round()).abs() < 1e-6;
        let powers: Vec<(f64, String)> = ticks.iter().filter(is_power).cloned().collect();
        let is_crowded =
            |ticks: &[(f64, String)]| ticks.windows(2).any(|pair| self.up(pair[0].0) - self.up(pair[1].0) < APART);
        let mut ticks = if is_crowded(&ticks) && powers.len() > 1 { powers } else { ticks };
        while is_crowded(&ticks) {
            ticks = ticks.into_iter().step_by(2).collect();
        }
        let text = |value: f64, text: String| if value < ALL { text } else { "1M".to_owned() };
        ticks.into_iter().map(|(value, name)| (self.up(value), text(value, name))).collect()
    }

    /// The bar of undecided rays.
    pub(super) fn bar(&self, choice: &Choice) -> Option<Frame> {
        let x = self.across(choice.x);
        let bar = Frame { left: x - 4, right: x + 4, top: self.up(choice.undecided), bottom: self.log_end() - 1 };
        (choice.undecided > 0.0).then_some(bar)
    }

    /// Corners of the line along choices that nothing beats in both.
    pub(super) fn front(&self) -> Vec<Point> {
        let mut at: Vec<Point> = self.marks.iter().filter(|m| m.choice.is_front).map(|m| m.at).collect();
        at.sort_unstable();
        at.windows(2).flat_map(|p| [p[0], (p[1].0, p[0].1)]).chain(at.last().copied()).collect()
    }

    /// What that line covers.
    fn dashed(&self) -> Vec<Frame> {
        self.front().windows(2).map(|pair| Frame::along([pair[0], pair[1]], 1)).collect()
    }

    /// The place of the strip's title and the side that it begins at: where the dashed line does not cross it.
    pub(super) fn title(&self, text: &str) -> (Place, Point) {
        let (width, y) = (width_of(text), self.log_end() + HEAD / 2 + 1);
        let lefts = [LEFT + GAP, RIGHT - GAP - width];
        let is_free = |left: &i32| !self.dashed().iter().any(|line| line.meets(on_line(*left, width, y).frame));
        let left = lefts.into_iter().find(is_free).unwrap_or(lefts[0]);
        (on_line(left, width, y), if left == lefts[0] { (left, y) } else { (left + width, y) })
    }
}
